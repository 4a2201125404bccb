// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Formulas of fill_guides.
#ifndef STILLRAY_DENOISE_FILL_GUIDES_SHARED_H
#define STILLRAY_DENOISE_FILL_GUIDES_SHARED_H

#ifdef __cplusplus
#include "core/shared.h"
#endif

SHARED_BEGIN

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

SHARED_END

#endif
