// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/cpu/fused/fused.h"

#include <atomic>

#include "core/parallel.h"
#include "denoise/row_scratch.h"
#include "denoise/simd/picture_parts.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "denoise/cpu/fused/antialias_parts.cpp"

#include <hwy/foreach_target.h>  // IWYU pragma: keep

#include <hwy/highway.h>

#include "denoise/simd/antialias_rows-inl.h"

HWY_BEFORE_NAMESPACE();
namespace stillray {
namespace HWY_NAMESPACE {
namespace {

/// Remodulates each row of the image just before it is read; three rows are kept.
/// \return the count of RemodulateRow for the rows y0..y1
int64_t AntialiasPartsRows(const PictureParts& parts, const AntialiasInput& in,
                           const AntialiasParameters& p, int y0, int y1, Image3* out) {
  const int width = in.previous.width();
  const RowScratch kept(width, 10 + TextureBand::kRows);
  const auto colour_row = [&](int c, int row) { return kept.Row(row % 3 * 3 + c); };
  TextureBand texture(in, kept, 10);
  const bool clamps_light = ClampsLight(in);
  const auto compose = [&](int row) {
    float* const to[3] = {colour_row(0, row), colour_row(1, row), colour_row(2, row)};
    const int64_t bad = cpu::RemodulateRow(parts, width, row, to);
    if (clamps_light) {
      texture.AddRow(row, to);
    }
    return bad;
  };
  if (y0 > 0) {
    compose(y0 - 1);  // counted by the band that contains this row
  }
  int64_t bad = compose(y0);
  StillRows still(in.motion, y0);
  for (int y = y0; y < y1; ++y) {
    if (y + 1 < in.previous.height()) {
      const int64_t bad_below = compose(y + 1);
      bad += y + 1 < y1 ? bad_below : 0;
    }
    RowsAround rows = FindRowsAround(in.motion, in.guides, in.length, y, colour_row);
    rows.ratio = RatioRow(in, y, kept.Row(9));
    if (clamps_light) {
      rows.texture = texture.Around(y);
    }
    NextRow<kMostFetched> next;
    AddPictureParts(parts, y + 2, &next);
    still.Around(y) ? AntialiasRow<true>(rows, next, in, p, y, out)
                    : AntialiasRow<false>(rows, next, in, p, y, out);
  }
  FinishStreams();
  return bad;
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace stillray
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stillray::cpu {

HWY_EXPORT(AntialiasPartsRows);

int64_t AntialiasParts(const PictureParts& parts, const AntialiasInput& in,
                       const AntialiasParameters& p, Image3* out) {
  std::atomic<int64_t> bad = 0;
  ParallelRows(in.previous.height(), 24, [&](int y0, int y1) {
    bad += HWY_DYNAMIC_DISPATCH(AntialiasPartsRows)(parts, in, p, y0, y1, out);
  });
  return bad;
}

}  // namespace stillray::cpu
#endif
