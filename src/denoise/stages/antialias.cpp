// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/stages/antialias.h"

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
  const RowScratch scratch(in.previous.width(), 1);
  StillRows still(in.motion, y0);
  for (int y = y0; y < y1; ++y) {
    RowsAround rows = FindRowsAround(in.motion, in.guides, in.length, y,
                                     [&](int c, int row) { return colour[c].Row(row); });
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
