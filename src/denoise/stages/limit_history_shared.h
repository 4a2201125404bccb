// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Formulas of limit_history.
#ifndef STILLRAY_DENOISE_LIMIT_HISTORY_SHARED_H
#define STILLRAY_DENOISE_LIMIT_HISTORY_SHARED_H

#ifdef __cplusplus
#include "core/shared.h"
#endif

SHARED_BEGIN

// Luminance compressed to 0..1 about the signal's mean, so that one bright sample cannot outvote
// its neighbourhood.
SHARED_FN float CompressLuminance(float l, float mean) {
  return l / (l + mean);
}

// Variance of a compressed luminance: first order about `l`, and never more than a variable in
// 0..1 with that mean can have (Bhatia and Davis 2000).
SHARED_FN float CompressVariance(float l, float variance, float mean) {
  float s = l + mean;
  float slope = mean / (s * s);
  float c = l / s;
  return min(slope * slope * variance, c * (1.0f - c));
}

// The history length that a Kalman filter would still give credit for, when present and history
// differ by d with expected noise `noise` (both blurred) and a pixel's own sample has variance
// `variance`.
SHARED_FN float LimitedLength(float length, float weights2, float d, float noise, float variance,
                              float dead, float gain) {
  float bias2 = max(0.0f, d * d - (1.0f + dead) * noise);
  float limit = 1.0f / max(weights2 + gain * bias2 / max(variance, 1e-8f), 1e-6f);
  return bias2 > 0.0f ? min(length, limit) : length;
}

SHARED_END

#endif
