// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/stages/restore_detail.h"

#include "core/parallel.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "denoise/stages/restore_detail.cpp"

#include <hwy/foreach_target.h>  // IWYU pragma: keep

#include <hwy/highway.h>

#include "denoise/simd/vector_math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace stillray {
namespace HWY_NAMESPACE {
namespace {

void BeginDetailRows(const DetailInput& in, const SignalHistory& residual,
                     const GuidePlanes& guides, float alpha_min, int y0, int y1, FilterPlanes* mean,
                     Image1* valid) {
  const DF d;
  const VF zero = hn::Zero(d);
  const VF one = hn::Set(d, 1.0f);
  const VF least = hn::Set(d, alpha_min);
  const VF rest = hn::Set(d, 2.0f - alpha_min);
  const int width = valid->width();
  for (int y = y0; y < y1; ++y) {
    for (int x = 0; x < width; x += LaneCount()) {
      const VF length = hn::LoadU(d, residual.length.Row(y) + x);
      const MF known = hn::And(hn::Gt(hn::LoadU(d, guides.inverse_depth.Row(y) + x), zero),
                               hn::Gt(length, zero));
      const VF samples = hn::Max(hn::LoadU(d, in.light->samples.Row(y) + x), one);
      const VF of_average = hn::Div(least, hn::Mul(rest, samples));
      const VF of_mean = hn::Div(one, hn::IfThenElse(known, length, one));
      const VF variance =
          hn::Mul(hn::LoadU(d, in.variance->Row(y) + x), hn::Max(of_mean, of_average));
      StoreInRow(d, hn::IfThenElseZero(known, one), valid->Row(y), x, width);
      StoreInRow(d, hn::IfThenElseZero(known, variance), mean->variance.Row(y), x, width);
      for (int c = 0; c < 3; ++c) {
        StoreInRow(d, hn::LoadU(d, residual.colour[c].Row(y) + x), mean->colour[c].Row(y), x,
                   width);
      }
    }
  }
}

/// See DetailScale.
HWY_INLINE VF ScaleOf(VF filtered, VF variance) {
  const DF d;
  const VF noise = hn::Mul(hn::Set(d, kDetailNoise), variance);
  const VF square = hn::Add(hn::Mul(filtered, filtered), noise);
  return hn::Max(hn::Sqrt(square), hn::Set(d, kLeastDetailScale));
}

/// See ScaledDetail.
HWY_INLINE VF Scaled(VF residual, VF scale) {
  const DF d;
  return hn::Min(hn::Max(hn::Div(residual, scale), hn::Set(d, -kMostDetail)),
                 hn::Set(d, kMostDetail));
}

void MeasureDetailRows(const DetailInput& in, const FilterPlanes& mean, const Image1& valid, int y0,
                       int y1, FilterPlanes* measured) {
  const DF d;
  const VF zero = hn::Zero(d);
  const int width = valid.width();
  for (int y = y0; y < y1; ++y) {
    for (int x = 0; x < width; x += LaneCount()) {
      const MF used = hn::And(hn::Gt(hn::LoadU(d, valid.Row(y) + x), zero),
                              hn::Gt(hn::LoadU(d, in.light->samples.Row(y) + x), zero));
      const VF filtered = hn::LoadU(d, (*in.filtered)[0].Row(y) + x);
      const VF scale = ScaleOf(filtered, hn::LoadU(d, in.variance->Row(y) + x));
      const VF residual = hn::Sub(hn::LoadU(d, in.light->colour[0].Row(y) + x), filtered);
      const VF m = Scaled(hn::LoadU(d, mean.colour[0].Row(y) + x), scale);
      const VF product = hn::IfThenElseZero(used, hn::Mul(m, Scaled(residual, scale)));
      StoreInRow(d, product, measured->colour[0].Row(y), x, width);
      StoreInRow(d, hn::IfThenElseZero(used, hn::Mul(m, m)), measured->colour[1].Row(y), x, width);
      StoreInRow(d, zero, measured->variance.Row(y), x, width);
    }
  }
}

/// See DetailShare.
HWY_INLINE VF ShareOf(VF product, VF square, VF noise) {
  const DF d;
  const VF one = hn::Set(d, 1.0f);
  const MF some = hn::And(hn::Gt(product, hn::Zero(d)), hn::Gt(square, noise));
  const VF divisor = hn::IfThenElse(some, square, one);
  const VF wiener = hn::Div(hn::Sub(square, noise), divisor);
  return hn::IfThenElseZero(some, hn::Mul(hn::Min(hn::Div(product, divisor), one), wiener));
}

void RestoreDetailRows(const FilterPlanes& sums, const FilterPlanes& mean, const Image1& variance,
                       const Image1& valid, int y0, int y1, LumaImage3* filtered) {
  const DF d;
  const VF zero = hn::Zero(d);
  const int width = valid.width();
  for (int y = y0; y < y1; ++y) {
    for (int x = 0; x < width; x += LaneCount()) {
      const MF known = hn::Gt(hn::LoadU(d, valid.Row(y) + x), zero);
      if (hn::AllFalse(d, known)) {
        continue;
      }
      const VF scale =
          ScaleOf(hn::LoadU(d, (*filtered)[0].Row(y) + x), hn::LoadU(d, variance.Row(y) + x));
      const VF noise = hn::Div(hn::LoadU(d, mean.variance.Row(y) + x), hn::Mul(scale, scale));
      const VF share = ShareOf(hn::LoadU(d, sums.colour[0].Row(y) + x),
                               hn::LoadU(d, sums.colour[1].Row(y) + x), noise);
      for (int c = 0; c < 3; ++c) {
        float* light = (*filtered)[c].Row(y);
        const VF old = hn::LoadU(d, light + x);
        const VF added = hn::Mul(share, hn::LoadU(d, mean.colour[c].Row(y) + x));
        const VF restored = hn::Max(hn::Add(old, added), zero);
        StoreInRow(d, hn::IfThenElse(known, restored, old), light, x, width);
      }
    }
  }
}

void AccumulateResidualRows(const DetailInput& in, float alpha_min, int y0, int y1,
                            SignalHistory* residual) {
  const DF d;
  const VF one = hn::Set(d, 1.0f);
  const VF least = hn::Set(d, alpha_min);
  const VF most = hn::Set(d, kMostResidualSamples);
  const int width = residual->length.width();
  for (int y = y0; y < y1; ++y) {
    float* length = residual->length.Row(y);
    for (int x = 0; x < width; x += LaneCount()) {
      const VF samples = hn::LoadU(d, in.light->samples.Row(y) + x);
      const MF some = hn::Gt(samples, hn::Zero(d));
      const VF before = hn::LoadU(d, length + x);
      const VF after = hn::Min(hn::Add(before, samples), most);
      const VF alpha = hn::Max(hn::Div(samples, hn::IfThenElse(some, after, one)), least);
      StoreInRow(d, hn::IfThenElse(some, after, before), length, x, width);
      for (int c = 0; c < 3; ++c) {
        float* mean = residual->colour[c].Row(y);
        const VF old = hn::LoadU(d, mean + x);
        const VF now = hn::Sub(hn::LoadU(d, in.light->colour[c].Row(y) + x),
                               hn::LoadU(d, (*in.filtered)[c].Row(y) + x));
        const VF mixed = hn::Add(old, hn::Mul(alpha, hn::Sub(now, old)));
        StoreInRow(d, hn::IfThenElse(some, mixed, old), mean, x, width);
      }
    }
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace stillray
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stillray::cpu {

HWY_EXPORT(BeginDetailRows);
HWY_EXPORT(MeasureDetailRows);
HWY_EXPORT(RestoreDetailRows);
HWY_EXPORT(AccumulateResidualRows);

void BeginDetail(const DetailInput& in, const SignalHistory& residual, const GuidePlanes& guides,
                 const RestoreDetailParameters& p, FilterPlanes* mean, Image1* valid) {
  ParallelRows(valid->height(), 32, [&](int y0, int y1) {
    HWY_DYNAMIC_DISPATCH(BeginDetailRows)
    (in, residual, guides, p.alpha_min, y0, y1, mean, valid);
  });
}

void MeasureDetail(const DetailInput& in, const FilterPlanes& mean, const Image1& valid,
                   FilterPlanes* measured) {
  ParallelRows(valid.height(), 32, [&](int y0, int y1) {
    HWY_DYNAMIC_DISPATCH(MeasureDetailRows)(in, mean, valid, y0, y1, measured);
  });
}

void RestoreDetail(const FilterPlanes& sums, const FilterPlanes& mean, const Image1& variance,
                   const Image1& valid, LumaImage3* filtered) {
  ParallelRows(valid.height(), 32, [&](int y0, int y1) {
    HWY_DYNAMIC_DISPATCH(RestoreDetailRows)(sums, mean, variance, valid, y0, y1, filtered);
  });
}

void AccumulateResidual(const DetailInput& in, const RestoreDetailParameters& p,
                        SignalHistory* residual) {
  ParallelRows(residual->length.height(), 32, [&](int y0, int y1) {
    HWY_DYNAMIC_DISPATCH(AccumulateResidualRows)(in, p.alpha_min, y0, y1, residual);
  });
}

}  // namespace stillray::cpu
#endif
