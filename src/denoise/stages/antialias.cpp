// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/stages/antialias.h"

#include <algorithm>

#include "core/parallel.h"
#include "denoise/row_scratch.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "denoise/stages/antialias.cpp"

#include <hwy/foreach_target.h>  // IWYU pragma: keep

#include <hwy/highway.h>

#include "denoise/simd/antialias_rows-inl.h"

HWY_BEFORE_NAMESPACE();
namespace stillray {
namespace HWY_NAMESPACE {
namespace {

void AntialiasRows(const Image3& colour, const AntialiasInput& in, const AntialiasParameters& p,
                   int y0, int y1, Image3* out) {
  const RowScratch scratch(in.previous.width(), 1 + TextureBand::kRows);
  const auto colour_row = [&](int c, int row) { return colour[c].Row(row); };
  TextureBand texture(in, scratch, 1);
  const auto add_row = [&](int row) {
    const float* const picture[3] = {colour[0].Row(row), colour[1].Row(row), colour[2].Row(row)};
    texture.AddRow(row, picture);
  };
  const bool clamps_light = ClampsLight(in);
  for (int row = std::max(y0 - 1, 0); clamps_light && row <= y0; ++row) {
    add_row(row);
  }
  StillRows still(in.motion, y0);
  for (int y = y0; y < y1; ++y) {
    if (clamps_light && y + 1 < colour.height()) {
      add_row(y + 1);
    }
    RowsAround rows = FindRowsAround(in.motion, in.guides, in.length, y, colour_row);
    if (clamps_light) {
      rows.texture = texture.Around(y);
    }
    rows.ratio = RatioRow(in, y, scratch.Row(0));
    NextRow<kMostFetched> next;
    next.Add(colour, y + 2);
    still.Around(y) ? AntialiasRow<true>(rows, next, in, p, y, out)
                    : AntialiasRow<false>(rows, next, in, p, y, out);
  }
  FinishStreams();
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace stillray
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stillray::cpu {

HWY_EXPORT(AntialiasRows);

void Antialias(const Image3& colour, const AntialiasInput& in, const AntialiasParameters& p,
               Image3* out) {
  ParallelRows(colour.height(), 16, [&](int y0, int y1) {
    HWY_DYNAMIC_DISPATCH(AntialiasRows)(colour, in, p, y0, y1, out);
  });
}

}  // namespace stillray::cpu
#endif
