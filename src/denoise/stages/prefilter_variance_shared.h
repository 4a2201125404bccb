// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Parameters of prefilter_variance, and the limit of the smoothed variance. The denominator:
// LuminanceFactor of edge_stopping_shared.h.
#ifndef STILLRAY_DENOISE_PREFILTER_VARIANCE_SHARED_H
#define STILLRAY_DENOISE_PREFILTER_VARIANCE_SHARED_H

#ifdef __cplusplus
#include "core/shared.h"
#endif

SHARED_BEGIN

SHARED_BLOCK(PrefilterVarianceParameters) {
  int prefilter_variance;         // 0: the pixel's own variance
  int luminance_scale_deviation;  // 1: by standard deviation, 0: by variance (PSVGF as printed)
  float sigma_l;
  float luminance_epsilon;
  float luminance_floor;     // in units of radiance
  float short_history_blur;  // shorter histories have no luminance weight
  int volume_signals;        // bit s: signal s has only transmitted light, e.g. of volumes
  float volume_widening;     // largest factor of their sigma_l; 1: off
  float prefilter_limit;     // of the smoothed variance, relative to the pixel's own; 0: none
};

// The smoothed variance under that limit. A neighbour on another surface with a hundred times the
// variance would let the luminance weight accept any radiance. A part of the smoothed variance
// remains: the estimate of the pixel's own may be zero by chance.
const float kLeastOfSmoothed = 1.0f / 64.0f;
SHARED_FN float LimitedVariance(float smoothed, float own, float limit) {
  return limit > 0.0f ? min(smoothed, limit * own + kLeastOfSmoothed * smoothed) : smoothed;
}

// Factor of sigma_l for radiance of volumes, from the confidence in the last frame's radiance.
// Smoke changes, so that fewer samples are accumulated, and has no texture that the filter could
// blur.
const float kLeastConfidence = 1e-6f;  // against a division by 0
SHARED_FN float VolumeWidening(float confidence, float most) {
  return min(1.0f / sqrt(max(confidence, kLeastConfidence)), most);
}

SHARED_END

#endif
