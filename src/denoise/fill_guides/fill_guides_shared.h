// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Formulas of fill_guides.
#ifndef STILLRAY_DENOISE_FILL_GUIDES_SHARED_H
#define STILLRAY_DENOISE_FILL_GUIDES_SHARED_H

#ifdef __cplusplus
#include "core/shared.h"
namespace stillray {
using glm::floor;
}  // namespace stillray
#endif

SHARED_BEGIN

// The pyramid.

const int kPyramidFactor = 3;

// Size of the level above one of this size.
SHARED_FN int CellsOf(int size) {
  return (size + kPyramidFactor - 1) / kPyramidFactor;
}

// The level above is read at (x + 1/2) / 3 - 1/2: between the cell before the parent and the parent
// for the first of three children, at the parent for the second, after it for the third.
SHARED_FN int FirstParent(int x) {
  return x / kPyramidFactor - (x % kPyramidFactor == 0 ? 1 : 0);
}

// Weight of the cell after FirstParent.
SHARED_FN float SecondParentWeight(int x) {
  int child = x % kPyramidFactor;
  return child == 0 ? 2.0f / 3.0f : (child == 1 ? 0.0f : 1.0f / 3.0f);
}

SHARED_FN float MixParents(float first, float second, float weight) {
  return first * (1.0f - weight) + second * weight;
}

// Held guides.

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
