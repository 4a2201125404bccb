// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/stages/prefilter_variance.h"

#include "core/parallel.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "denoise/stages/prefilter_variance.cpp"

#include <hwy/foreach_target.h>  // IWYU pragma: keep

#include <hwy/highway.h>

#include "denoise/simd/vector_math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace stillray {
namespace HWY_NAMESPACE {
namespace {

void PrefilterVarianceRows(const Image1& variance, const Image1& present, const Image1& length,
                           const PrefilterVarianceParameters& p, int y0, int y1, Image1* spread) {
  const DF d;
  const int width = spread->width();
  const int radius = p.smooth ? 1 : 0;
  for (int y = y0; y < y1; ++y) {
    for (int x = 0; x < width; x += LaneCount()) {
      VF sum = hn::Zero(d);
      VF sum_weight = hn::Zero(d);
      for (int dy = -radius; dy <= radius; ++dy) {
        for (int dx = -radius; dx <= radius; ++dx) {
          const VF kernel = hn::Set(d, (dx == 0 ? 2.0f : 1.0f) * (dy == 0 ? 2.0f : 1.0f));
          const VF w = hn::Mul(kernel, hn::LoadU(d, present.Row(y + dy) + x + dx));
          sum = hn::MulAdd(w, hn::LoadU(d, variance.Row(y + dy) + x + dx), sum);
          sum_weight = hn::Add(sum_weight, w);
        }
      }
      const VF smoothed = hn::Div(sum, hn::Max(sum_weight, hn::Set(d, 1.0f)));
      const VF result = p.square_root ? hn::Sqrt(smoothed) : smoothed;
      const MF bounded =
          hn::And(hn::Gt(hn::LoadU(d, present.Row(y) + x), hn::Zero(d)),
                  hn::Ge(hn::LoadU(d, length.Row(y) + x), hn::Set(d, p.unbounded_below)));
      StoreInRow(d, hn::IfThenElse(bounded, result, hn::Set(d, kUnboundedSpread)), spread->Row(y),
                 x, width);
    }
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace stillray
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stillray::cpu {

HWY_EXPORT(PrefilterVarianceRows);

void PrefilterVariance(const Image1& variance, const Image1& present, const Image1& length,
                       const PrefilterVarianceParameters& p, Image1* spread) {
  ParallelRows(spread->height(), 32, [&](int y0, int y1) {
    HWY_DYNAMIC_DISPATCH(PrefilterVarianceRows)(variance, present, length, p, y0, y1, spread);
  });
}

}  // namespace stillray::cpu
#endif
