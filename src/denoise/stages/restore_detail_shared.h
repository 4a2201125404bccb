// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Formulas of restore_detail.
#ifndef STILLRAY_DENOISE_RESTORE_DETAIL_SHARED_H
#define STILLRAY_DENOISE_RESTORE_DETAIL_SHARED_H

#ifdef __cplusplus
#include "core/shared.h"
#endif

SHARED_BEGIN

SHARED_BLOCK(RestoreDetailParameters) {
  int detail_signals;  // bit s: the detail of signal s is restored
  float alpha_min;     // smallest weight of a frame in the mean residual
};

// Share of the samples' variance in the scale of a pixel. Without it nearly black pixels would
// outweigh all others.
const float kDetailNoise = 0.1f;

const float kLeastDetailScale = 1e-15f;

// Largest residual in units of the scale; low enough that the square of a product of two stays
// finite.
const float kMostDetail = 1e4f;

// Samples up to which the mean residual is a plain mean, whatever alpha_min is.
const float kMostResidualSamples = 65536.0f;

// The unit of a pixel's residuals, which gives bright and dark pixels of a region about equal
// weight. `variance` is the variance of single samples.
SHARED_FN float DetailScale(float filtered, float variance) {
  return max(sqrt(filtered * filtered + kDetailNoise * variance), kLeastDetailScale);
}

SHARED_FN float ScaledDetail(float residual, float scale) {
  return clamp(residual / scale, -kMostDetail, kMostDetail);
}

// The variance of a mean residual of `length` samples: first that of a plain mean, later that of an
// exponential average of frames with `samples` samples each (the count of this frame). The noise of
// the filtered signal in the residual is neglected.
SHARED_FN float ResidualVariance(float variance, float samples, float length, float alpha_min) {
  const float of_average = alpha_min / ((2.0f - alpha_min) * max(samples, 1.0f));
  return variance * max(1.0f / length, of_average);
}

// The factor of the mean residual m of earlier frames that has the least squared error against the
// residuals r of this frame is E(m r) / E(m^2): the noise of r is independent of m and cancels in
// E(m r). The means are over few samples, so that this ratio is uncertain and would let noise pass
// where there is no detail. Without detail E(m^2) is the variance of m's noise, and the Wiener
// filter of m gives 0.
// \param product, square, noise  E(m r), E(m^2), variance of m's noise
// \return 0..1
SHARED_FN float DetailShare(float product, float square, float noise) {
  if (!(product > 0.0f && square > noise)) {
    return 0.0f;
  }
  return min(product / square, 1.0f) * ((square - noise) / square);
}

// The weight of this frame's `samples` in the mean residual of `length` samples with them.
SHARED_FN float ResidualAlpha(float samples, float length, float alpha_min) {
  return max(samples / length, alpha_min);
}

SHARED_END

#endif
