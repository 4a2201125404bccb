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

// Size of the pyramid level above a level of this size.
SHARED_FN int CellsOf(int size) {
  return (size + kPyramidFactor - 1) / kPyramidFactor;
}

// The first of two cells of the level above, which is interpolated at (x + 1/2) / 3 - 1/2: between
// the cell before the parent and the parent for the first of three children, at the parent for the
// second, between the parent and the next cell for the third.
SHARED_FN int FirstParent(int x) {
  return x / kPyramidFactor - (x % kPyramidFactor == 0 ? 1 : 0);
}

// Weight of the second cell, FirstParent + 1.
SHARED_FN float SecondParentWeight(int x) {
  int child = x % kPyramidFactor;
  return child == 0 ? 2.0f / 3.0f : (child == 1 ? 0.0f : 1.0f / 3.0f);
}

SHARED_FN float LerpParents(float first, float second, float weight) {
  return first * (1.0f - weight) + second * weight;
}

// Held guides.

// Motion up to this counts as zero, pixels per frame.
const float kMinMotion = 1e-3f;
// Least relative difference of inverse depth between different surfaces, used without ids.
const float kDepthTolerance = 0.1f;
const int kMaxGhostRadius = 16;

// Coordinate of a pixel's held guides: the end of the motion, rounded down after adding `shift` in
// [0, 1).
SHARED_FN float HeldCoordinate(int x, float motion, float shift) {
  return floor(float(x) + motion + shift);
}

// Whether two depths belong to different surfaces.
SHARED_FN bool DepthsDiffer(float za, float zb) {
  return abs(1.0f / za - 1.0f / zb) > kDepthTolerance / za;
}

// Radius in pixels around a ghost within which held guides of its surface are rejected: the mean
// distance of known pixels, 3/4 sqrt(pixels / known), rounded up. Squares are compared, so that the
// result does not depend on the rounding of a root.
SHARED_FN int GhostRadius(float known, float pixels) {
  int radius = 1;
  while (radius < kMaxGhostRadius && float(16 * radius * radius) * known < 9.0f * pixels) {
    ++radius;
  }
  return radius;
}

SHARED_END

#endif
