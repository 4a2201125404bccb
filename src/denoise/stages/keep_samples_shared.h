// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Formulas of keep_samples.
#ifndef STILLRAY_DENOISE_KEEP_SAMPLES_SHARED_H
#define STILLRAY_DENOISE_KEEP_SAMPLES_SHARED_H

#ifdef __cplusplus
#include "core/shared.h"
#endif

SHARED_BEGIN

SHARED_BLOCK(KeepSamplesParameters) {
  int kept_signals;  // bit s: signal s has second moments
};

// Samples that a pixel must have, on average, for the variance within it to be known.
const float kFewestKept = 2.0f;

// Margin of the measured noise: the mean of squares is uncertain itself, and where nothing but
// noise is removed none of it shall come back.
const float kKeptNoise = 1.2f;

SHARED_FN bool KeepsSamples(float inverse_depth, float samples) {
  return inverse_depth > 0.0f && samples >= kFewestKept;
}

// Variance of the mean of n samples. \param within  the mean square of their differences from that
// mean, which has n - 1 degrees of freedom \param variance  of single samples, from the history
SHARED_FN float SampleNoise(float within, float variance, float n) {
  return kKeptNoise * max(within / (n - 1.0f), variance / n);
}

// The weight of the filtered light y beside the sample x that has the least mean square error:
// noise / (noise + bias^2), with E (x - y)^2 = noise + bias^2 (James and Stein 1961).
SHARED_FN float FilteredShare(float difference2, float noise) {
  return difference2 > noise ? noise / difference2 : 1.0f;
}

SHARED_END

#endif
