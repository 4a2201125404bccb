// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Formulas of merge_future.
#ifndef STILLRAY_DENOISE_MERGE_FUTURE_SHARED_H
#define STILLRAY_DENOISE_MERGE_FUTURE_SHARED_H

#ifdef __cplusplus
#include "core/shared.h"
#endif

SHARED_BEGIN

// Share of the future in the merged mean. The variance of each mean is its sum of squared weights
// times a common variance of single samples: the optimal weights are proportional to its inverse.
SHARED_FN float FutureShare(float length, float weights2, float future_length,
                            float future_weights2) {
  float share = weights2 / max(weights2 + future_weights2, 1e-12f);
  return future_length <= 0.0f ? 0.0f : (length <= 0.0f ? 1.0f : share);
}

// Sum of squared weights of the merged mean.
SHARED_FN float MergedWeights2(float weights2, float future_weights2, float share) {
  float keep = 1.0f - share;
  return keep * keep * weights2 + share * share * future_weights2;
}

SHARED_END

#endif
