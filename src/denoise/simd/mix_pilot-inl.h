// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// mix_pilot for a vector of pixels: alone, or at the end of the level that computes the mean.
#if defined(STILLRAY_DENOISE_SIMD_MIX_PILOT_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef STILLRAY_DENOISE_SIMD_MIX_PILOT_INL_H_
#undef STILLRAY_DENOISE_SIMD_MIX_PILOT_INL_H_
#else
#define STILLRAY_DENOISE_SIMD_MIX_PILOT_INL_H_
#endif

#include "denoise/simd/vector_math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace stillray {
namespace HWY_NAMESPACE {

/// A luminance and its variance.
struct PilotValue {
  VF luminance, variance;
};

/// \param full  history length up to which the pilot is the mean alone
HWY_INLINE PilotValue MixedPilot(PilotValue own, PilotValue mean, VF length, float full) {
  const DF d;
  const VF counted = hn::Max(length, hn::Set(d, 1e-6f));
  const VF share = hn::Min(hn::Div(hn::Set(d, full), counted), hn::Set(d, 1.0f));
  const VF own_deviation = hn::Sqrt(own.variance);
  const VF mean_deviation = hn::Sqrt(mean.variance);
  const VF deviation = hn::MulAdd(share, hn::Sub(mean_deviation, own_deviation), own_deviation);
  return {hn::MulAdd(share, hn::Sub(mean.luminance, own.luminance), own.luminance),
          hn::Mul(deviation, deviation)};
}

}  // namespace HWY_NAMESPACE
}  // namespace stillray
HWY_AFTER_NAMESPACE();

#endif  // include guard
