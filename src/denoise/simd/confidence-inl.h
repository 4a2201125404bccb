// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The confidence in the last frame's radiance, for vectors of pixels (reproject_shared.h).

#if defined(STILLRAY_DENOISE_SIMD_CONFIDENCE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef STILLRAY_DENOISE_SIMD_CONFIDENCE_INL_H_
#undef STILLRAY_DENOISE_SIMD_CONFIDENCE_INL_H_
#else
#define STILLRAY_DENOISE_SIMD_CONFIDENCE_INL_H_
#endif

#include "denoise/simd/vector_math-inl.h"
#include "stillray/image.h"

HWY_BEFORE_NAMESPACE();
namespace stillray {
namespace HWY_NAMESPACE {

/// UsedConfidence of the pixels x, x + 1, ... of row y.
HWY_INLINE VF ConfidenceOf(const Image1& confidence, int x, int y) {
  const DF d;
  const VF one = hn::Set(d, 1.0f);
  const VF given = hn::LoadU(d, confidence.Row(y) + x);
  const VF clamped = hn::Min(hn::Max(given, hn::Zero(d)), one);
  return hn::IfThenElse(hn::IsNaN(given), one, clamped);
}

/// ConfidentAlpha for a vector of pixels.
HWY_INLINE VF ConfidentAlpha(VF least, VF confidence) {
  const DF d;
  const VF one = hn::Set(d, 1.0f);
  const VF sum = hn::Add(least, hn::Mul(confidence, hn::Sub(one, least)));
  const VF raised = hn::Div(least, hn::Max(sum, hn::Set(d, 1e-30f)));
  return hn::IfThenElse(hn::Lt(confidence, one), raised, least);
}

}  // namespace HWY_NAMESPACE
}  // namespace stillray
HWY_AFTER_NAMESPACE();

#endif  // include guard
