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
  float kept_reach;  // see ShareOfFiltered; 0: no limit
};

// Least number of samples for which the variance within a pixel is known.
const float kFewestKept = 2.0f;

// Margin of the measured noise: the mean of squares is itself uncertain, and where the filter
// removes only noise, none of it should return.
const float kKeptNoise = 1.2f;

SHARED_FN bool KeepsSamples(float inverse_depth, float samples) {
  return inverse_depth > 0.0f && samples >= kFewestKept;
}

// Variance of the mean of n samples.
// \param within  the mean square of the samples' differences from that mean (n - 1 degrees of
//     freedom)
// \param variance  of single samples, from the history
SHARED_FN float SampleNoise(float within, float variance, float n) {
  return kKeptNoise * max(within / (n - 1.0f), variance / n);
}

// The weight of the filtered signal y beside the sample x that has the least mean square error:
// noise / (noise + bias^2), with E (x - y)^2 = noise + bias^2 (James and Stein 1961).
SHARED_FN float FilteredShare(float difference2, float noise) {
  return difference2 > noise ? noise / difference2 : 1.0f;
}

// kept_reach for pixels with n samples whose variance is estimated from the neighbouring pixels.
// The more samples, the rarer are means that differ strongly by chance.
SHARED_FN float ReachOfEstimates(float n) {
  return max(0.5f, n / 32.0f);
}

// FilteredShare for one pixel. A pixel whose own noise is unknown may have a rare bright sample:
// the part of its deviation from the filtered signal that is kept is limited to reach (difference2
// / noise)^(1/2) times the root mean square of the deviations around. Without noise there is no
// limit.
// \param difference2, noise  means around the pixel
// \param deviation  |x - y| of the pixel
SHARED_FN float ShareOfFiltered(float difference2, float noise, float deviation, float reach) {
  float share = FilteredShare(difference2, noise);
  float limit = reach * difference2;
  float needed = deviation * sqrt(noise);
  return reach > 0.0f && needed > limit ? 1.0f - (1.0f - share) * (limit / needed) : share;
}

SHARED_END

#endif
