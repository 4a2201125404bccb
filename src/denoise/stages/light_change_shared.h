// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Changes of radiance, as logarithms, and their significance; for follow_light and limit_history.
#ifndef STILLRAY_DENOISE_LIGHT_CHANGE_SHARED_H
#define STILLRAY_DENOISE_LIGHT_CHANGE_SHARED_H

#ifdef __cplusplus
#include "core/shared.h"
#endif

SHARED_BEGIN

// Bound of a change.
const float kMostChange = 1.0f;

// Logarithm of the ratio of radiance to its earlier value.
SHARED_FN float LogChange(float light, float before) {
  bool both = light > 1e-20f && before > 1e-20f;
  return both ? clamp(log(light / before), -kMostChange, kMostChange) : 0.0f;
}

// Variance of the mean of several changes, from their scatter.
// \param square  mean of their squares
// \param known   their number
// \return the variance of the mean
SHARED_FN float VarianceOfChange(float mean, float square, float known) {
  return max(square - mean * mean, 0.0f) / max(known, 1.0f);
}

// A mean change, shrunk towards 0 as far as noise explains it (James and Stein 1961).
// \param noise  a multiple of the variance of the mean
SHARED_FN float ShrunkenChange(float mean, float noise) {
  return mean * max(1.0f - noise / max(mean * mean, 1e-12f), 0.0f);
}

SHARED_END

#endif
