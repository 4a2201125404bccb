// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Formulas of keep_mirrors.
#ifndef STILLRAY_DENOISE_KEEP_MIRRORS_SHARED_H
#define STILLRAY_DENOISE_KEEP_MIRRORS_SHARED_H

#ifdef __cplusplus
#include "core/shared.h"
#endif

SHARED_BEGIN

SHARED_BLOCK(KeepMirrorsParameters) {
  float mirror_roughness;  // largest roughness of a mirror
  int mirror_signals;      // bit s: signal s has reflected or refracted light
};

// Ratio of the variance of a sample to the mean squared difference from the two of its eight
// neighbours that are nearest in luminance. For independent samples the ratio is 3.5 (normal), 2.5
// (exponential), 1.2 (one bright sample in twenty). Smaller values keep more detail of noiseless
// mirrors, but also the noise of reflections and refractions with few paths (builtin:spheres).
const float kNearestNoise = 3.0f;

// In a mirror that is static in the image, reflections are mostly static too: the history is
// correct, and the noise must be this many times smaller for the sample to be kept.
const float kStillNoise = 4.0f;
const float kStillMotion = 1.0f / 64.0f;  // pixels per frame

// Squared difference of luminance that stands for a missing neighbour.
const float kNoNeighbour = 1e37f;

// Whether the sample of a pixel may be kept. A surface with NaN roughness is not a mirror.
SHARED_FN bool IsMirror(float inverse_depth, float samples, float roughness, float limit) {
  return inverse_depth > 0.0f && samples > 0.0f && roughness >= 0.0f && roughness <= limit;
}

// Variance of a sample from its two smallest squared differences of luminance; 0 with fewer than
// two neighbours.
SHARED_FN float NoiseOfNearest(float first, float second, float scale) {
  return second < kNoNeighbour ? scale * (0.5f * (first + second)) : 0.0f;
}

SHARED_END

#endif
