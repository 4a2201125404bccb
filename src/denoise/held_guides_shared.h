// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Formulas of guides that are held from frame to frame.
#ifndef STILLRAY_DENOISE_HELD_GUIDES_SHARED_H
#define STILLRAY_DENOISE_HELD_GUIDES_SHARED_H

#ifdef __cplusplus
#include "core/shared.h"
namespace stillray {
using glm::floor;
}  // namespace stillray
#endif

SHARED_BEGIN

// Below this many pixels per frame nothing moves.
const float kStill = 1e-3f;
// Change of inverse depth that shows another surface, where there are no ids.
const float kOtherDepth = 0.1f;
const int kMostGhostRadius = 16;

// A coordinate of where a pixel's held guides lie: along the motion, rounded up or down.
SHARED_FN float HeldPlace(int x, float motion, float shift) {
  return floor(float(x) + motion + shift);
}

// Whether two surfaces are not the same, by their depths alone.
SHARED_FN bool DepthsDiffer(float za, float zb) {
  return abs(1.0f / za - 1.0f / zb) > kOtherDepth / za;
}

// How far around a pixel where something has left what was held of it is given up: the mean
// distance of new paths, 3/4 of the root of pixels per known pixel, rounded up. Without a root,
// whose last bit would decide.
SHARED_FN int GhostRadius(float known, float pixels) {
  int radius = 1;
  while (radius < kMostGhostRadius && float(16 * radius * radius) * known < 9.0f * pixels) {
    ++radius;
  }
  return radius;
}

SHARED_END

#endif
