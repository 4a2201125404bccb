// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Formulas of fxaa.
#ifndef STILLRAY_DENOISE_FXAA_SHARED_H
#define STILLRAY_DENOISE_FXAA_SHARED_H

#ifdef __cplusplus
#include "core/shared.h"
#endif

SHARED_BEGIN

SHARED_BLOCK(FxaaParameters) {
  int fxaa_sparse;  // 1: the filter fades out from the first sample of a pixel to the fourth
};

const int kFxaaReach = 8;
const float kFxaaContrast = 0.2f;  // least contrast of an edge, relative to the brightest value

// Contrast is relative, so that edges do not depend on exposure.
SHARED_FN bool IsEdge(float lowest, float highest) {
  return highest - lowest > highest * kFxaaContrast;
}

// Fraction of the neighbour across the edge for a pixel that is `near` pixels from the nearer end
// of a step of `near` + `far` pixels in all, if the step at that end bends to the pixel's side: a
// straight edge covers half of the neighbour at the end and nothing in the middle.
SHARED_FN float AcrossShare(float near, float far) {
  return max(0.5f - near / (near + far), 0.0f);
}

// 1 up to one sample, 0 from the fourth sample on.
SHARED_FN float FxaaStrength(float length) {
  return clamp((4.0f - length) / 3.0f, 0.0f, 1.0f);
}

SHARED_END

#endif
