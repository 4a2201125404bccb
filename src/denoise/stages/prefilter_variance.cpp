// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/stages/prefilter_variance.h"

#include "core/parallel.h"
#include "denoise/row_scratch.h"
#include "denoise/simd/next_row.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "denoise/stages/prefilter_variance.cpp"

#include <hwy/foreach_target.h>  // IWYU pragma: keep

#include <hwy/highway.h>

#include "denoise/simd/luminance_stop-inl.h"
#include "denoise/simd/stream_rows-inl.h"
#include "denoise/simd/vector_math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace stillray {
namespace HWY_NAMESPACE {
namespace {

/// What the next row reads and writes.
NextRow<8> NextRowOf(const PrefilterVarianceInput& in, const PrefilterVarianceParameters& p, int y,
                     const Image1& stop) {
  NextRow<8> next;
  next.Add(*in.variance, y + 1);
  if (in.full == nullptr) {
    next.Add(*in.present, y + 1);
  }
  next.Add(*in.luminance, y);
  AddStreamed(stop, y, &next);
  if (p.unbounded_below > 0) {
    next.Add(*in.length, y);
  }
  return next;
}

void PrefilterVarianceRows(const PrefilterVarianceInput& in, const PrefilterVarianceParameters& p,
                           int y0, int y1, Image1* stop) {
  const DF d;
  const int width = stop->width();
  const RowScratch scratch(width, 2);
  for (int y = y0; y < y1; ++y) {
    const StopSource source(RowsOf(in, y), p, width, {scratch.Row(0), scratch.Row<uint32_t>(1)});
    const NextRow<8> next = NextRowOf(in, p, y + 1, *stop);
    for (int x = 0; x < width; x += LaneCount()) {
      next.Fetch(x);
      StreamInRow(d, source.Stop(x), stop->Row(y), x, width);
    }
  }
  FinishStreams();
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace stillray
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stillray::cpu {

HWY_EXPORT(PrefilterVarianceRows);

void PrefilterVariance(const PrefilterVarianceInput& in, const PrefilterVarianceParameters& p,
                       Image1* stop) {
  ParallelRows(stop->height(), 32, [&](int y0, int y1) {
    HWY_DYNAMIC_DISPATCH(PrefilterVarianceRows)(in, p, y0, y1, stop);
  });
}

}  // namespace stillray::cpu
#endif
