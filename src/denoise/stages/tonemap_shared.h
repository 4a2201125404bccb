// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Tone curves: scene-linear, exposed light to display-linear 0..1, per channel.
#ifndef STILLRAY_DENOISE_TONEMAP_SHARED_H
#define STILLRAY_DENOISE_TONEMAP_SHARED_H

#ifdef __cplusplus
#include "core/shared.h"
#endif

SHARED_BEGIN

SHARED_FN float ReinhardCurve(float x) {
  return x / (1.0f + x);
}

// Hable's filmic curve (Uncharted 2, GDC 2010), white at 11.2.
SHARED_FN float HableCurve(float x) {
  return (x * (0.15f * x + 0.05f) + 0.004f) / (x * (0.15f * x + 0.5f) + 0.06f) - 0.02f / 0.3f;
}
SHARED_FN float FilmicCurve(float x) {
  return HableCurve(2.0f * x) / HableCurve(11.2f);
}

// Narkowicz's fit of the ACES reference rendering and output transforms (2016), with the light
// scaled by 0.6 as he gives it for the original exposure.
SHARED_FN float AcesCurve(float x) {
  float s = 0.6f * x;
  return clamp(s * (2.51f * s + 0.03f) / (s * (2.43f * s + 0.59f) + 0.14f), 0.0f, 1.0f);
}

// curve: 0 linear, 1 Reinhard, 2 filmic, 3 ACES.
SHARED_FN float ToneCurve(float x, int curve) {
  if (curve == 1) {
    return ReinhardCurve(x);
  }
  if (curve == 2) {
    return clamp(FilmicCurve(x), 0.0f, 1.0f);
  }
  if (curve == 3) {
    return AcesCurve(x);
  }
  return clamp(x, 0.0f, 1.0f);
}

SHARED_END

#endif
