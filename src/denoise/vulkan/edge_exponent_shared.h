// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Edge-stopping functions as exponents of 2: devices have few units for exponentials, so the
// weights of a tap are added as exponents, and one exponential is computed for all of them.
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

// Scale of NormalExponent2. `sigma_n`: CurvedSigmaN of the pixel, or the setting if curvature is
// off.
SHARED_FN float NormalScale(float sigma_n, bool curved) {
  return curved ? sigma_n * kExponentsOfE : sigma_n;
}

// The binary logarithm of NormalWeightAt, where `scale` is the pixel's NormalScale. Cosines up to
// zero are replaced by a tiny one: the weight is then 0 for every sigma_n above 1.5, and negligible
// below that.
SHARED_FN float NormalExponent2(float cosine, float scale, bool curved) {
  return scale * (curved ? LogCosine(cosine) : log2(max(cosine, 1e-30f)));
}

// The negated depth exponents of one pixel's taps, without divisions by values common to all taps.
// per_ip: 1 / ip, the depth of the pixel. Differences are computed before scaling, so that the
// rounding of per_ip does not matter.

// PlaneDepthExponent times log2(e). `expected`: ip + g . offset; scale: log2(e) per_ip / tolerance
SHARED_FN float PlaneDepthExponent2(float expected, float iq, float scale) {
  return abs(expected - iq) * scale;
}

// GradientDepthExponent times log2(e), without max_slope. change, epsilon: sigma_z (g . offset) /
// ip and depth_epsilon, both over log2(e)
SHARED_FN float GradientDepthExponent2(float ip, float iq, float change, float epsilon) {
  return abs(iq - ip) / (iq * (abs(change) + epsilon));
}

SHARED_END

#endif
