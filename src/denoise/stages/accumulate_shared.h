// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Formulas of accumulate.
#ifndef STILLRAY_DENOISE_ACCUMULATE_SHARED_H
#define STILLRAY_DENOISE_ACCUMULATE_SHARED_H

#ifdef __cplusplus
#include "core/shared.h"
#endif

SHARED_BEGIN

SHARED_BLOCK(AccumulateParameters) {
  float alpha_min;
  float alpha_moments;
  int history_weight_constant;  // 1: alpha_min wherever there is history (SVGF)
  int max_history;              // samples; 0: no limit
};

// Weight of the new frame. PSVGF section 4.2: max(alpha_min, 1 / age), with age in samples: n new
// samples after `length` old ones. SVGF eq. 1 (constant_weight): alpha_min wherever there is
// history.
SHARED_FN float NewFrameWeight(float length, float n, float alpha_min, bool constant_weight) {
  float share = n / max(length + n, 1e-6f);
  float alpha = constant_weight ? alpha_min : max(alpha_min, share);
  return n <= 0.0f ? 0.0f : (length <= 0.0f ? 1.0f : min(alpha, 1.0f));
}

// Variance of a mixture in deviation form: with E'[x] = E[x] + a d, d = x - E[x],
// E'[x^2] - E'[x]^2 = (1 - a) (V + a d^2) + a V_within: no difference of large numbers.
SHARED_FN float MixedVariance(float variance, float d, float within, float alpha) {
  return (1.0f - alpha) * (variance + alpha * d * d) + alpha * within;
}

// Sum of squared sample weights after adding n samples with weight alpha / n each.
SHARED_FN float MixedWeights2(float weights2, float n, float alpha) {
  float old = (1.0f - alpha) * (1.0f - alpha) * weights2;
  return n > 0.0f ? old + alpha * alpha / n : weights2;
}

SHARED_END

#endif
