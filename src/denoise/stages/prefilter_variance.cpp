// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/stages/prefilter_variance.h"

#include "core/parallel.h"
#include "denoise/simd/next_row.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "denoise/stages/prefilter_variance.cpp"

#include <hwy/foreach_target.h>  // IWYU pragma: keep

#include <hwy/highway.h>

#include "denoise/simd/vector_math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace stillray {
namespace HWY_NAMESPACE {
namespace {

void PrefilterVarianceRows(const Image1& luminance, const Image1& variance, const Image1& present,
                           const Image1& length, const PrefilterVarianceParameters& p, int y0,
                           int y1, Image1* stop) {
  const DF d;
  const int width = stop->width();
  const int radius = p.smooth ? 1 : 0;
  for (int y = y0; y < y1; ++y) {
    NextRow<8> next;
    next.Add(variance, y + 2);
    next.Add(present, y + 2);
    next.Add(luminance, y + 1);
    next.Add(*stop, y + 1);
    for (int x = 0; x < width; x += LaneCount()) {
      next.Fetch(x);
      VF sum = hn::Zero(d);
      VF sum_weight = hn::Zero(d);
      for (int dy = -radius; dy <= radius; ++dy) {
        for (int dx = -radius; dx <= radius; ++dx) {
          const VF kernel = hn::Set(d, (dx == 0 ? 2.0f : 1.0f) * (dy == 0 ? 2.0f : 1.0f));
          const MF there = hn::Gt(hn::LoadU(d, present.Row(y + dy) + x + dx), hn::Zero(d));
          const VF w = hn::IfThenElseZero(there, kernel);
          sum = hn::MulAdd(w, hn::LoadU(d, variance.Row(y + dy) + x + dx), sum);
          sum_weight = hn::Add(sum_weight, w);
        }
      }
      const VF smoothed = hn::Div(sum, hn::Max(sum_weight, hn::Set(d, 1.0f)));
      const VF spread = p.square_root ? hn::Sqrt(smoothed) : smoothed;
      const VF l = hn::Abs(hn::LoadU(d, luminance.Row(y) + x));
      const VF tolerance =
          hn::MulAdd(hn::Set(d, p.sigma_l), spread,
                     hn::MulAdd(hn::Set(d, p.luminance_epsilon), l, hn::Set(d, 1e-12f)));
      MF bounded = hn::Gt(hn::LoadU(d, present.Row(y) + x), hn::Zero(d));
      if (p.unbounded_below > 0) {
        const VF old = hn::LoadU(d, length.Row(y) + x);
        bounded = hn::And(bounded, hn::Ge(old, hn::Set(d, p.unbounded_below)));
      }
      StoreInRow(d, hn::IfThenElseZero(bounded, hn::Div(hn::Set(d, kLog2E), tolerance)),
                 stop->Row(y), x, width);
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

void PrefilterVariance(const Image1& luminance, const Image1& variance, const Image1& present,
                       const Image1& length, const PrefilterVarianceParameters& p, Image1* stop) {
  ParallelRows(stop->height(), 32, [&](int y0, int y1) {
    HWY_DYNAMIC_DISPATCH(PrefilterVarianceRows)
    (luminance, variance, present, length, p, y0, y1, stop);
  });
}

}  // namespace stillray::cpu
#endif
