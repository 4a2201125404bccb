// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Formulas of suppress_fireflies.
#ifndef STILLRAY_DENOISE_SUPPRESS_FIREFLIES_SHARED_H
#define STILLRAY_DENOISE_SUPPRESS_FIREFLIES_SHARED_H

#ifdef __cplusplus
#include "core/shared.h"
#endif

SHARED_BEGIN

// Factor of a colour of luminance l under the curve, and the factor that undoes it, of the
// compressed luminance.
SHARED_FN float CompressScale(float l) {
  return 1.0f / (1.0f + l);
}
SHARED_FN float ExpandScale(float l) {
  return 1.0f / max(1.0f - l, 1e-6f);
}

// Scales a sample of luminance l down to that of its brightest neighbour.
SHARED_FN float ClampScale(float l, float brightest) {
  return l > brightest ? brightest / l : 1.0f;
}

SHARED_END

#endif
