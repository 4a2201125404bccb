// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Formulas of suppress_fireflies.
#ifndef STILLRAY_DENOISE_SUPPRESS_FIREFLIES_SHARED_H
#define STILLRAY_DENOISE_SUPPRESS_FIREFLIES_SHARED_H

#ifdef __cplusplus
#include "core/shared.h"
#endif

SHARED_BEGIN

// The luminance up to which compression is the identity; compressed luminance is at most twice
// this. Reinhard's curve, which is nonlinear everywhere, makes means of noisy radiance too dark (by
// a quarter in builtin:lights at one sample per pixel); the mean of samples below the knee is
// exact.
const float kKnee = 32.0f;

// Factor of a colour of luminance l: it approaches 2 kKnee / l. Value and slope are continuous.
SHARED_FN float CompressScale(float l) {
  float part = kKnee / max(l, kKnee);
  return part * (2.0f - part);
}

// The inverse factor, of the compressed luminance. The result is at most 1000 kKnee: beyond, half
// precision cannot represent the distance from the limit.
SHARED_FN float ExpandScale(float l) {
  float part = max(l / kKnee, 1.0f);
  return 1.0f / (part * max(2.0f - part, 1e-3f));
}

// Factor that scales a sample of luminance l down to the luminance of its brightest neighbour.
SHARED_FN float ClampScale(float l, float brightest) {
  return l > brightest ? brightest / l : 1.0f;
}

SHARED_END

#endif
