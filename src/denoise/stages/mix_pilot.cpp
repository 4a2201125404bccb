// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/stages/mix_pilot.h"

#include "core/parallel.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "denoise/stages/mix_pilot.cpp"

#include <hwy/foreach_target.h>  // IWYU pragma: keep

#include <hwy/highway.h>

#include "denoise/simd/vector_math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace stillray {
namespace HWY_NAMESPACE {
namespace {

void MixPilotRows(const MixPilotInput& in, float full, int y0, int y1, Image1* luminance,
                  Image1* variance) {
  const DF d;
  const VF one = hn::Set(d, 1.0f);
  const VF least = hn::Set(d, 1e-6f);
  const VF vfull = hn::Set(d, full);
  const int width = luminance->width();
  for (int y = y0; y < y1; ++y) {
    for (int x = 0; x < width; x += LaneCount()) {
      const VF length = hn::Max(hn::LoadU(d, in.length->Row(y) + x), least);
      const VF share = hn::Min(hn::Div(vfull, length), one);
      const VF own = hn::LoadU(d, in.luminance->Row(y) + x);
      const VF mean = hn::LoadU(d, luminance->Row(y) + x);
      const VF own_deviation = hn::Sqrt(hn::LoadU(d, in.variance->Row(y) + x));
      const VF mean_deviation = hn::Sqrt(hn::LoadU(d, variance->Row(y) + x));
      const VF deviation = hn::MulAdd(share, hn::Sub(mean_deviation, own_deviation), own_deviation);
      StoreInRow(d, hn::MulAdd(share, hn::Sub(mean, own), own), luminance->Row(y), x, width);
      StoreInRow(d, hn::Mul(deviation, deviation), variance->Row(y), x, width);
    }
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace stillray
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stillray::cpu {

HWY_EXPORT(MixPilotRows);

void MixPilot(const MixPilotInput& in, float full, Image1* luminance, Image1* variance) {
  ParallelRows(luminance->height(), 32, [&](int y0, int y1) {
    HWY_DYNAMIC_DISPATCH(MixPilotRows)(in, full, y0, y1, luminance, variance);
  });
}

}  // namespace stillray::cpu
#endif
