// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Formulas of prepare_guides.
#ifndef STILLRAY_DENOISE_PREPARE_GUIDES_SHARED_H
#define STILLRAY_DENOISE_PREPARE_GUIDES_SHARED_H

#ifdef __cplusplus
#include "core/shared.h"
#endif

SHARED_BEGIN

// Neighbours whose normals differ by more than this (25 degrees) are not used for the slope.
const float kGradientMinCosine = 0.906f;

// Slope of inverse depth along one axis from the differences to both neighbours. Neighbours on
// other surfaces are excluded. Of two valid differences the smaller is used, since an edge within
// one id can only make a difference too large.
SHARED_FN float OneSidedGradient(float before, float centre, float after, float before_ok,
                                 float after_ok) {
  float backward = centre - before;
  float forward = after - centre;
  float both = abs(backward) < abs(forward) ? backward : forward;
  return after_ok > 0.0f ? (before_ok > 0.0f ? both : forward)
                         : (before_ok > 0.0f ? backward : 0.0f);
}

// The square of the angle by which the normal turns per pixel, from the cosines to the normals of
// the four neighbours. Of two opposite neighbours the more similar one counts, so that a flat
// surface beside an edge does not count as curved.
SHARED_FN float SquaredTurn(float left, float right, float up, float down) {
  // 1 - cos a = a^2 / 2
  return 2.0f * max(2.0f - max(left, right) - max(up, down), 0.0f);
}

SHARED_END

#endif
