// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/stages/keep_samples.h"

#include "core/parallel.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "denoise/stages/keep_samples.cpp"

#include <hwy/foreach_target.h>  // IWYU pragma: keep

#include <hwy/highway.h>

#include "denoise/simd/vector_math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace stillray {
namespace HWY_NAMESPACE {
namespace {

void MeasureSampleRows(const KeepSamplesInput& in, int y0, int y1, FilterPlanes* measured,
                       Image1* valid) {
  const DF d;
  const VF zero = hn::Zero(d);
  const VF one = hn::Set(d, 1.0f);
  const VF fewest = hn::Set(d, kFewestKept);
  const VF margin = hn::Set(d, kKeptNoise);
  const NewLight& light = *in.light;
  const int width = light.samples.width();
  for (int y = y0; y < y1; ++y) {
    for (int x = 0; x < width; x += LaneCount()) {
      const VF n = hn::LoadU(d, light.samples.Row(y) + x);
      const MF kept =
          hn::And(hn::Gt(hn::LoadU(d, in.inverse_depth->Row(y) + x), zero), hn::Ge(n, fewest));
      const VF several = hn::IfThenElse(kept, n, fewest);
      const VF difference = hn::Sub(hn::LoadU(d, light.colour[0].Row(y) + x),
                                    hn::LoadU(d, (*in.filtered)[0].Row(y) + x));
      const VF within = hn::Div(hn::LoadU(d, light.within.Row(y) + x), hn::Sub(several, one));
      const VF known = hn::Div(hn::LoadU(d, in.variance->Row(y) + x), several);
      const VF noise = hn::Mul(margin, hn::Max(within, known));
      StoreInRow(d, hn::IfThenElseZero(kept, one), valid->Row(y), x, width);
      StoreInRow(d, hn::IfThenElseZero(kept, hn::Mul(difference, difference)),
                 measured->colour[0].Row(y), x, width);
      StoreInRow(d, hn::IfThenElseZero(kept, noise), measured->colour[1].Row(y), x, width);
      StoreInRow(d, zero, measured->variance.Row(y), x, width);
    }
  }
}

void KeepSampleRows(const FilterPlanes& blurred, const Image1& valid, const NewLight& light,
                    float reach, int y0, int y1, LumaImage3* filtered) {
  const DF d;
  const VF zero = hn::Zero(d);
  const VF one = hn::Set(d, 1.0f);
  const int width = valid.width();
  for (int y = y0; y < y1; ++y) {
    for (int x = 0; x < width; x += LaneCount()) {
      const VF square = hn::LoadU(d, blurred.colour[0].Row(y) + x);
      const VF noise = hn::LoadU(d, blurred.colour[1].Row(y) + x);
      const MF keep = hn::And(hn::Gt(hn::LoadU(d, valid.Row(y) + x), zero), hn::Gt(square, noise));
      if (hn::AllFalse(d, keep)) {
        continue;
      }
      VF share = hn::Div(noise, hn::IfThenElse(keep, square, one));
      if (reach > 0) {
        const VF deviation = hn::AbsDiff(hn::LoadU(d, light.colour[0].Row(y) + x),
                                         hn::LoadU(d, (*filtered)[0].Row(y) + x));
        const VF limit = hn::Mul(hn::Set(d, reach), square);
        const VF needed = hn::Mul(deviation, hn::Sqrt(noise));
        const MF beyond = hn::Gt(needed, limit);
        const VF part = hn::Div(limit, hn::IfThenElse(beyond, needed, one));
        const VF limited = hn::Sub(one, hn::Mul(hn::Sub(one, share), part));
        share = hn::IfThenElse(beyond, limited, share);
      }
      for (int c = 0; c < 3; ++c) {
        const VF kept = hn::LoadU(d, light.colour[c].Row(y) + x);
        const VF old = hn::LoadU(d, (*filtered)[c].Row(y) + x);
        const VF blend = hn::Add(kept, hn::Mul(share, hn::Sub(old, kept)));
        StoreInRow(d, hn::IfThenElse(keep, blend, old), (*filtered)[c].Row(y), x, width);
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

HWY_EXPORT(MeasureSampleRows);
HWY_EXPORT(KeepSampleRows);

void MeasureSamples(const KeepSamplesInput& in, FilterPlanes* measured, Image1* valid) {
  ParallelRows(valid->height(), 32, [&](int y0, int y1) {
    HWY_DYNAMIC_DISPATCH(MeasureSampleRows)(in, y0, y1, measured, valid);
  });
}

void KeepSamples(const FilterPlanes& blurred, const Image1& valid, const NewLight& light,
                 float reach, LumaImage3* filtered) {
  ParallelRows(valid.height(), 32, [&](int y0, int y1) {
    HWY_DYNAMIC_DISPATCH(KeepSampleRows)(blurred, valid, light, reach, y0, y1, filtered);
  });
}

}  // namespace stillray::cpu
#endif
