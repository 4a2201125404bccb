// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Formulas of estimate_variance.
#ifndef STILLRAY_DENOISE_ESTIMATE_VARIANCE_SHARED_H
#define STILLRAY_DENOISE_ESTIMATE_VARIANCE_SHARED_H

#ifdef __cplusplus
#include "core/shared.h"
#endif

#include "denoise/stages/edge_stopping_shared.h"

SHARED_BEGIN

SHARED_BLOCK(EstimateVarianceParameters) {
  EdgeStopping edges;
  int variance_of_mean;  // 1: of the accumulated mean, 0: of a single frame
  int short_history;     // kShortHistory...
  float short_history_length;
  float short_history_boost;
  float least_evidence;  // sum of the spatial weights below which the variance is kUnknownVariance
  int short_history_radius;  // radius of the spatial estimate, pixels, at most 3
};

// Estimators of the variance of short histories.
const int kShortHistoryNone = 0;  // the variance stays 0
const int kShortHistorySpread = 1;
const int kShortHistorySecondDifference = 2;

// Large enough that the luminance weight is 1, small enough that sums stay finite.
const float kUnknownVariance = 1e20f;

// Variance of the accumulated mean from the spread of single samples about it: the estimate is
// raised by 1 / (1 - weights2), since the mean was fitted to the same samples, and multiplied by
// weights2.
SHARED_FN float VarianceOfMean(float variance, float weights2) {
  float unbiased = variance / max(1.0f - weights2, 0.25f);
  return unbiased * weights2;
}

// The expected square of the second difference l(a) - 2 l(p) + l(b) of three collinear pixels is
// this many times the variance of one pixel.
const float kSecondDifferenceVariances = 6.0f;
// Weight of the spread relative to the weights of the second differences. The spread is the only
// estimate where no three pixels of a surface are collinear.
const float kSpreadWeight = 0.05f;

// \param square, weight  sums over the second differences of a neighbourhood
// \param spread          variance of its pixels about their mean
SHARED_FN float SecondDifferenceVariance(float square, float weight, float spread) {
  return (square / kSecondDifferenceVariances + kSpreadWeight * spread) / (weight + kSpreadWeight);
}

// Confidence in the spatial estimate grows as the history does: (full / length)^boost.
SHARED_FN float ShortHistoryBoost(float length, float full, float boost) {
  return pow(max(full / max(length, 1.0f), 1.0f), boost);
}

// Share of the neighbourhood's mean in the luminance that the first levels compare. For histories
// of unlimited length it converges to 0.
SHARED_FN float PilotShare(float length, float full) {
  return min(full / max(length, 1e-6f), 1.0f);
}

// Variance of a mix of the pixel's own value with a pilot that contains this value.
SHARED_FN float PilotVariance(float own, float pilot, float share) {
  float deviation = sqrt(own) + share * (sqrt(pilot) - sqrt(own));
  return deviation * deviation;
}

SHARED_END

#endif
