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

#include "denoise/simd/vector_math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace stillray {
namespace HWY_NAMESPACE {
namespace {

/// Sums of the variance over the pixels that have light, and of their weights.
struct Smoothed {
  VF sum, weight;
};

/// 1 2 1 down a column.
HWY_INLINE Smoothed SmoothDown(const Image1& variance, const Image1& present, int x, int y) {
  const DF d;
  VF v[3];
  VF w[3];
  for (int i = 0; i < 3; ++i) {
    const MF there = hn::Gt(hn::LoadU(d, present.Row(y - 1 + i) + x), hn::Zero(d));
    v[i] = hn::IfThenElseZero(there, hn::LoadU(d, variance.Row(y - 1 + i) + x));
    w[i] = hn::IfThenElseZero(there, hn::Set(d, 1.0f));
  }
  const VF two = hn::Set(d, 2.0f);
  return {hn::MulAdd(two, v[1], hn::Add(v[0], v[2])), hn::MulAdd(two, w[1], hn::Add(w[0], w[2]))};
}

/// 1 2 1 across what SmoothDown has left in rows.
HWY_INLINE VF SmoothAcross(const float* row, int x) {
  const DF d;
  return hn::MulAdd(hn::Set(d, 2.0f), hn::LoadU(d, row + x),
                    hn::Add(hn::LoadU(d, row + x - 1), hn::LoadU(d, row + x + 1)));
}

/// sum / max(weight, 1). Away from edges all weights are 16: their division is exact, and costs one
/// step instead of the divider's time.
HWY_INLINE VF OverWeight(VF sum, VF weight) {
  const DF d;
  if (hn::AllTrue(d, hn::Eq(weight, hn::Set(d, 16.0f)))) {
    return hn::Mul(sum, hn::Set(d, 1.0f / 16));
  }
  return hn::Div(sum, hn::Max(weight, hn::Set(d, 1.0f)));
}

void PrefilterVarianceRows(const Image1& luminance, const Image1& variance, const Image1& present,
                           const Image1& length, const PrefilterVarianceParameters& p, int y0,
                           int y1, Image1* stop) {
  const DF d;
  const int width = stop->width();
  const RowScratch scratch(width, 2);
  float* sums = scratch.Row(0);
  float* weights = scratch.Row(1);
  for (int y = y0; y < y1; ++y) {
    NextRow<8> next;
    next.Add(variance, y + 2);
    next.Add(present, y + 2);
    next.Add(luminance, y + 1);
    next.Add(*stop, y + 1);
    if (p.unbounded_below > 0) {
      next.Add(length, y + 1);
    }
    if (p.smooth) {
      // One column more to the left and right: the border, which has nothing.
      sums[-1] = weights[-1] = sums[width] = weights[width] = 0;
      for (int x = 0; x < width; x += LaneCount()) {
        const Smoothed down = SmoothDown(variance, present, x, y);
        StoreInRow(d, down.sum, sums, x, width);
        StoreInRow(d, down.weight, weights, x, width);
      }
    }
    for (int x = 0; x < width; x += LaneCount()) {
      next.Fetch(x);
      const MF there = hn::Gt(hn::LoadU(d, present.Row(y) + x), hn::Zero(d));
      VF smoothed = hn::IfThenElseZero(there, hn::LoadU(d, variance.Row(y) + x));
      if (p.smooth) {
        smoothed = OverWeight(SmoothAcross(sums, x), SmoothAcross(weights, x));
      }
      const VF spread = p.square_root ? hn::Sqrt(smoothed) : smoothed;
      const VF l = hn::Abs(hn::LoadU(d, luminance.Row(y) + x));
      const VF tolerance =
          hn::MulAdd(hn::Set(d, p.sigma_l), spread,
                     hn::MulAdd(hn::Set(d, p.luminance_epsilon), l, hn::Set(d, 1e-12f)));
      MF bounded = there;
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
