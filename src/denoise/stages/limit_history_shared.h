// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Formulas of limit_history.
#ifndef STILLRAY_DENOISE_LIMIT_HISTORY_SHARED_H
#define STILLRAY_DENOISE_LIMIT_HISTORY_SHARED_H

#ifdef __cplusplus
#include "core/shared.h"
#endif

SHARED_BEGIN

SHARED_BLOCK(LimitHistoryParameters) {
  float limit_dead;
  float limit_gain;
};

// Luminance compressed to 0..1, 1/2 at `scale`, which bounds the influence of one bright sample on
// its neighbourhood.
SHARED_FN float CompressLuminance(float l, float scale) {
  return max(l, 0.0f) / (max(l, 0.0f) + scale);
}

// The compressed luminance under another scale: exact for a single value.
SHARED_FN float RescaleCompressed(float c, float old_scale, float scale) {
  return c * old_scale / max(c * old_scale + (1.0f - c) * scale, 1e-30f);
}

// Variance of compressed single samples whose mean is c, when the samples themselves have mean l
// and this variance: first order about l, and never more than that of a variable in 0..1 with mean
// c (Bhatia and Davis 2000), which sparse bright samples come close to.
SHARED_FN float CompressedVariance(float c, float l, float variance, float scale) {
  // In two steps: after black frames the scale is so small that its square would underflow.
  float s = max(l, 0.0f) + scale;
  float slope = scale / s / s;
  return min(slope * variance * slope, c * (1.0f - c));
}

// The compression scale, which follows the light without changing from frame to frame: the
// history's as long as the mean luminance is within a factor of two of it, else the mean.
SHARED_FN float CompressionScale(float history_scale, float mean_luminance) {
  bool near_by = mean_luminance < 2.0f * history_scale && history_scale < 2.0f * mean_luminance;
  return near_by ? history_scale : max(mean_luminance, 1e-20f);
}

// The history length to which a Kalman filter would reduce the history, when present and history
// differ by d with expected noise `noise` (both blurred) and single samples of the neighbourhood
// have variance `variance`.
SHARED_FN float LimitedLength(float length, float weights2, float d, float noise, float variance,
                              float dead, float gain) {
  float bias2 = max(0.0f, d * d - (1.0f + dead) * noise);
  float limit = 1.0f / max(weights2 + gain * bias2 / max(variance, 1e-8f), 1e-6f);
  return bias2 > 0.0f ? min(length, limit) : length;
}

SHARED_END

#endif
