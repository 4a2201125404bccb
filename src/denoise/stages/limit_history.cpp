// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/stages/limit_history.h"

#include <algorithm>

#include "core/parallel.h"
#include "denoise/simd/next_row.h"
#include "denoise/stages/limit_history_shared.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "denoise/stages/limit_history.cpp"

#include <hwy/foreach_target.h>  // IWYU pragma: keep

#include <hwy/highway.h>

#include "denoise/simd/vector_math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace stillray {
namespace HWY_NAMESPACE {
namespace {

/// See CompressedVariance.
HWY_INLINE VF SampleVariance(const SignalHistory& before, VF scale, int x, int y) {
  const DF d;
  const VF c = hn::LoadU(d, before.compressed.Row(y) + x);
  const VF s = hn::Add(hn::Max(hn::LoadU(d, before.mean.Row(y) + x), hn::Zero(d)), scale);
  const VF slope = hn::Div(scale, hn::Mul(s, s));
  return hn::Min(hn::Mul(hn::Mul(slope, slope), hn::LoadU(d, before.variance.Row(y) + x)),
                 hn::Mul(c, hn::Sub(hn::Set(d, 1.0f), c)));
}

void CompareWithHistoryRows(const NewLight& light, const SignalHistory& before,
                            const GuidePlanes& guides, const LimitHistoryParameters& p, int y0,
                            int y1, FilterPlanes* compared, Image1* present) {
  const DF d;
  const VF zero = hn::Zero(d);
  const VF scale = hn::Set(d, p.scale);
  const VF one = hn::Set(d, 1.0f);
  const int width = light.samples.width();
  for (int y = y0; y < y1; ++y) {
    NextRow<20> next;
    for (const Image1* plane :
         {&light.samples, &light.colour[0], &guides.inverse_depth, &before.length, &before.mean,
          &before.variance, &before.compressed, &before.weights2,
          static_cast<const Image1*>(present), static_cast<const Image1*>(&compared->variance)}) {
      next.Add(*plane, y + 1);
    }
    next.Add(compared->colour, y + 1);
    for (int x = 0; x < width; x += LaneCount()) {
      next.Fetch(x);
      const VF n = hn::LoadU(d, light.samples.Row(y) + x);
      const MF both =
          hn::And(hn::Gt(hn::LoadU(d, guides.inverse_depth.Row(y) + x), zero),
                  hn::And(hn::Gt(n, zero), hn::Gt(hn::LoadU(d, before.length.Row(y) + x), zero)));
      const VF l = hn::Max(hn::LoadU(d, light.colour[0].Row(y) + x), zero);
      const VF now = hn::Div(l, hn::Add(l, scale));
      const VF then = hn::LoadU(d, before.compressed.Row(y) + x);
      const VF single = SampleVariance(before, scale, x, y);
      const VF noise = hn::Mul(
          single, hn::Add(hn::Div(one, hn::Max(n, one)), hn::LoadU(d, before.weights2.Row(y) + x)));
      StoreInRow(d, hn::IfThenElseZero(both, one), present->Row(y), x, width);
      StoreInRow(d, hn::IfThenElseZero(both, now), compared->colour[0].Row(y), x, width);
      StoreInRow(d, hn::IfThenElseZero(both, then), compared->colour[1].Row(y), x, width);
      StoreInRow(d, hn::IfThenElseZero(both, single), compared->colour[2].Row(y), x, width);
      StoreInRow(d, hn::IfThenElseZero(both, noise), compared->variance.Row(y), x, width);
    }
  }
}

void LimitHistoryRows(const FilterPlanes& blurred, const Image1& present,
                      const SignalHistory& before, const LimitHistoryParameters& p, int y0, int y1,
                      Image1* limit) {
  const DF d;
  const VF zero = hn::Zero(d);
  const int width = limit->width();
  for (int y = y0; y < y1; ++y) {
    NextRow<8> next;
    for (const Image1* plane : {&before.length, &blurred.variance, &before.weights2, &present,
                                static_cast<const Image1*>(limit)}) {
      next.Add(*plane, y + 1);
    }
    next.Add(blurred.colour, y + 1);
    for (int x = 0; x < width; x += LaneCount()) {
      next.Fetch(x);
      const VF length = hn::LoadU(d, before.length.Row(y) + x);
      const VF difference = hn::Sub(hn::LoadU(d, blurred.colour[0].Row(y) + x),
                                    hn::LoadU(d, blurred.colour[1].Row(y) + x));
      const VF noise = hn::LoadU(d, blurred.variance.Row(y) + x);
      const VF square = hn::Mul(difference, difference);
      const VF bias2 = hn::Max(zero, hn::NegMulAdd(hn::Set(d, 1.0f + p.dead), noise, square));
      const VF own = hn::Max(hn::LoadU(d, blurred.colour[2].Row(y) + x), hn::Set(d, 1e-8f));
      const VF distrust = hn::MulAdd(hn::Set(d, p.gain), hn::Div(bias2, own),
                                     hn::LoadU(d, before.weights2.Row(y) + x));
      const VF limited = hn::Div(hn::Set(d, 1.0f), hn::Max(distrust, hn::Set(d, 1e-6f)));
      const MF biased =
          hn::And(hn::Gt(bias2, zero), hn::Gt(hn::LoadU(d, present.Row(y) + x), zero));
      StoreInRow(d, hn::IfThenElse(biased, hn::Min(length, limited), length), limit->Row(y), x,
                 width);
    }
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace stillray
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stillray {

void RescaleHistory(float scale, SignalHistory* history) {
  ParallelRows(history->compressed.height(), 32, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      float* c = history->compressed.Row(y);
      for (int x = 0; x < history->compressed.width(); ++x) {
        c[x] = RescaleCompressed(c[x], history->compressed_scale, scale);
      }
    }
  });
  history->compressed_scale = scale;
}

namespace cpu {

HWY_EXPORT(CompareWithHistoryRows);
HWY_EXPORT(LimitHistoryRows);

void CompareWithHistory(const NewLight& light, const SignalHistory& before,
                        const GuidePlanes& guides, const LimitHistoryParameters& p,
                        FilterPlanes* compared, Image1* present) {
  ParallelRows(present->height(), 32, [&](int y0, int y1) {
    HWY_DYNAMIC_DISPATCH(CompareWithHistoryRows)
    (light, before, guides, p, y0, y1, compared, present);
  });
}

void LimitHistory(const FilterPlanes& blurred, const Image1& present, const SignalHistory& before,
                  const LimitHistoryParameters& p, Image1* limit) {
  ParallelRows(limit->height(), 32, [&](int y0, int y1) {
    HWY_DYNAMIC_DISPATCH(LimitHistoryRows)(blurred, present, before, p, y0, y1, limit);
  });
}

}  // namespace cpu
}  // namespace stillray
#endif
