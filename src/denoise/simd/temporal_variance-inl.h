// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The variance that a history tells of itself (stages/estimate_variance.h), on vectors: in that
// stage, or while the history is accumulated.
#if defined(STILLRAY_DENOISE_SIMD_TEMPORAL_VARIANCE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef STILLRAY_DENOISE_SIMD_TEMPORAL_VARIANCE_INL_H_
#undef STILLRAY_DENOISE_SIMD_TEMPORAL_VARIANCE_INL_H_
#else
#define STILLRAY_DENOISE_SIMD_TEMPORAL_VARIANCE_INL_H_
#endif

#include "denoise/simd/vector_math-inl.h"
#include "denoise/stages/estimate_variance.h"

HWY_BEFORE_NAMESPACE();
namespace stillray {
namespace HWY_NAMESPACE {

/// The history of one signal at some pixels.
struct HistoryMoments {
  VF length, variance, weights2;
  VF samples;  ///< of this frame, at least one
};

struct TemporalVariance {
  VF value;     ///< 0 where the history does not tell
  MF is_short;  ///< where it is too short for that
  MF missing;   ///< surfaces without any light
};

HWY_INLINE VF VarianceOfMean(VF variance, VF weights2) {
  const DF d;
  const VF least = hn::Max(hn::Sub(hn::Set(d, 1.0f), weights2), hn::Set(d, 0.25f));
  return hn::Mul(hn::Div(variance, least), weights2);
}

/// \param in_row  which of the pixels there are
HWY_INLINE TemporalVariance TemporalVarianceOf(const HistoryMoments& m, MF surface, MF in_row,
                                               const EstimateVarianceParameters& p) {
  const DF d;
  const MF known = hn::And(hn::Gt(m.length, hn::Zero(d)), surface);
  const MF full = hn::Ge(m.length, hn::Set(d, p.short_length));
  const VF variance =
      p.of_mean ? VarianceOfMean(m.variance, m.weights2) : hn::Div(m.variance, m.samples);
  return {hn::IfThenElseZero(hn::And(known, full), variance),
          hn::AndNot(full, hn::And(known, in_row)), hn::AndNot(known, surface)};
}

}  // namespace HWY_NAMESPACE
}  // namespace stillray
HWY_AFTER_NAMESPACE();

#endif  // include guard
