// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Edge-stopping functions as exponents of 2: devices compute exponentials in units that are few, so
// a tap's weights are added as exponents, and there is one exponential for all of them.
#ifndef STILLRAY_DENOISE_VULKAN_EDGE_EXPONENT_SHARED_H
#define STILLRAY_DENOISE_VULKAN_EDGE_EXPONENT_SHARED_H

#include "denoise/stages/edge_stopping_shared.h"

#ifdef __cplusplus
namespace stillray {
using glm::log2;
}  // namespace stillray
#endif

SHARED_BEGIN

const float kExponentsOfE = 1.44269504f;  // log2(e)

// The binary logarithm of NormalWeightAt, where `sigma_n` is that of the pixel: CurvedSigmaN, or
// the setting if curvature is off. Cosines up to zero count as a tiny one: the weight is then 0 for
// every sigma_n above 1.5, and below that too small to count.
SHARED_FN float NormalExponent2(float cosine, float sigma_n, bool curved) {
  return sigma_n * (curved ? LogCosine(cosine) * kExponentsOfE : log2(max(cosine, 1e-30f)));
}

SHARED_END

#endif
