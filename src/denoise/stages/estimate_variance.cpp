// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/stages/estimate_variance.h"

#include "core/parallel.h"
#include "denoise/simd/next_row.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "denoise/stages/estimate_variance.cpp"

#include <hwy/foreach_target.h>  // IWYU pragma: keep

#include <hwy/highway.h>

#include "denoise/simd/edge_stopping-inl.h"
#include "denoise/simd/vector_math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace stillray {
namespace HWY_NAMESPACE {
namespace {

HWY_INLINE VF VarianceOfMean(VF variance, VF weights2) {
  const DF d;
  const VF least = hn::Max(hn::Sub(hn::Set(d, 1.0f), weights2), hn::Set(d, 0.25f));
  return hn::Mul(hn::Div(variance, least), weights2);
}

HWY_INLINE VF ShortHistoryBoost(VF length, float full, float boost) {
  const DF d;
  const VF one = hn::Set(d, 1.0f);
  const VF ratio = hn::Max(hn::Div(hn::Set(d, full), hn::Max(length, one)), one);
  return Exp2(hn::Mul(hn::Set(d, boost), Log2(ratio)));
}

/// Variance of single samples from the 7x7 neighbourhood on the same surface, about each pixel's
/// mean.
HWY_INLINE VF SpatialVariance(const SignalHistory& h, const GuidePlanes& g,
                              const EstimateVarianceParameters& p, int x, int y) {
  const EdgeStopping& e = p.edges;
  const DF d;
  const VF zero = hn::Zero(d);
  const GuideCentre c = LoadGuideCentre(g, e, x, y);
  const VF mean_p = hn::LoadU(d, h.mean.Row(y) + x);
  VF sum_weight = zero;
  VF sum_d = zero;
  VF sum_d2 = zero;
  for (int dy = -3; dy <= 3; ++dy) {
    for (int dx = -3; dx <= 3; ++dx) {
      const int xq = x + dx;
      const VF cosine =
          hn::MulAdd(c.nx, hn::LoadU(d, g.normal[0].Row(y + dy) + xq),
                     hn::MulAdd(c.ny, hn::LoadU(d, g.normal[1].Row(y + dy) + xq),
                                hn::Mul(c.nz, hn::LoadU(d, g.normal[2].Row(y + dy) + xq))));
      const VF iq = hn::LoadU(d, g.inverse_depth.Row(y + dy) + xq);
      const MF keep =
          hn::And(hn::Gt(cosine, zero),
                  hn::And(hn::Gt(hn::LoadU(d, h.length.Row(y + dy) + xq), zero), hn::Gt(iq, zero)));
      const VF exponent =
          hn::Sub(NormalExponent(cosine, e.sigma_n),
                  DepthExponent(c, e, iq, static_cast<float>(dx), static_cast<float>(dy)));
      const VF w = hn::IfThenElseZero(keep, Exp2(exponent));
      const VF difference = hn::Sub(hn::LoadU(d, h.mean.Row(y + dy) + xq), mean_p);
      const VF second =
          hn::MulAdd(difference, difference, hn::LoadU(d, h.variance.Row(y + dy) + xq));
      sum_weight = hn::Add(sum_weight, w);
      sum_d = hn::MulAdd(w, difference, sum_d);
      sum_d2 = hn::MulAdd(w, second, sum_d2);
    }
  }
  const MF any = hn::Gt(sum_weight, zero);
  const VF scale = hn::Div(hn::Set(d, 1.0f), hn::IfThenElse(any, sum_weight, hn::Set(d, 1.0f)));
  const VF mean_d = hn::Mul(sum_d, scale);
  const VF variance = hn::NegMulAdd(mean_d, mean_d, hn::Mul(sum_d2, scale));
  const VF estimate = hn::IfThenElseZero(any, hn::Max(variance, zero));
  return hn::IfThenElse(hn::Lt(sum_weight, hn::Set(d, p.least_evidence)),
                        hn::Set(d, kUnknownVariance), estimate);
}

void EstimateVarianceRows(const SignalHistory& history, const Image1& samples,
                          const GuidePlanes& guides, const EstimateVarianceParameters& p, int y0,
                          int y1, Image1* variance) {
  const DF d;
  const VF zero = hn::Zero(d);
  const VF one = hn::Set(d, 1.0f);
  const int width = variance->width();
  for (int y = y0; y < y1; ++y) {
    NextRow<8> next;
    for (const Image1* plane :
         {&history.length, &history.weights2, &history.variance, &samples, &guides.inverse_depth}) {
      next.Add(*plane, y + 1);
    }
    next.Add(*variance, y + 1);
    for (int x = 0; x < width; x += LaneCount()) {
      next.Fetch(x);
      const VF length = hn::LoadU(d, history.length.Row(y) + x);
      const VF weights2 = hn::LoadU(d, history.weights2.Row(y) + x);
      const VF temporal = hn::LoadU(d, history.variance.Row(y) + x);
      const VF per_frame = hn::Div(one, hn::Max(hn::LoadU(d, samples.Row(y) + x), one));
      const MF known = hn::And(hn::Gt(length, zero),
                               hn::Gt(hn::LoadU(d, guides.inverse_depth.Row(y) + x), zero));
      const MF full = hn::Ge(length, hn::Set(d, p.short_length));
      VF result = p.of_mean ? VarianceOfMean(temporal, weights2) : hn::Mul(temporal, per_frame);
      const MF is_short = hn::AndNot(full, hn::And(known, InRow(x, width)));
      if (!hn::AllFalse(d, is_short)) {
        VF spatial = zero;
        if (p.spatial) {
          spatial = hn::Mul(SpatialVariance(history, guides, p, x, y),
                            ShortHistoryBoost(length, p.short_length, p.boost));
          spatial = hn::Mul(spatial, p.of_mean ? weights2 : per_frame);
        }
        result = hn::IfThenElse(is_short, spatial, result);
      }
      StoreInRow(d, hn::IfThenElseZero(known, result), variance->Row(y), x, width);
    }
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace stillray
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stillray::cpu {

HWY_EXPORT(EstimateVarianceRows);

void EstimateVariance(const SignalHistory& history, const Image1& samples,
                      const GuidePlanes& guides, const EstimateVarianceParameters& p,
                      Image1* variance) {
  ParallelRows(variance->height(), 16, [&](int y0, int y1) {
    HWY_DYNAMIC_DISPATCH(EstimateVarianceRows)(history, samples, guides, p, y0, y1, variance);
  });
}

}  // namespace stillray::cpu
#endif
