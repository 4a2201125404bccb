// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Lights without extent: KHR_lights_punctual.
#ifndef STILLRAY_RENDER_PUNCTUAL_SHARED_H
#define STILLRAY_RENDER_PUNCTUAL_SHARED_H

#ifdef __cplusplus
#include "render/shared.h"
#endif

STILLRAY_RENDER_BEGIN

// Values of LightType.
const int kLightPoint = 0;
const int kLightSpot = 1;
const int kLightDirectional = 2;

// A punctual light at one moment.
struct PunctualSource {
  vec3 position;
  int type;
  vec3 axis;  // unit direction of emission
  float range;
  vec3 intensity;
  float inner_cosine;  // cosine of a spot light's inner cone angle
  float outer_cosine;
  uint unused_0, unused_1, unused_2;
};

// Attenuation by the light's range at `distance`, without the inverse square falloff: the
// extension's recommended max(min(1 - (d / range)^4, 1), 0). Infinite range: 1.
SHARED_FN float RangeAttenuation(float distance, float range) {
  float ratio = distance / range;
  float ratio2 = ratio * ratio;
  return clamp(1.0f - ratio2 * ratio2, 0.0f, 1.0f);
}

// Attenuation of a spot light: 1 within the inner cone, 0 outside the outer, and in between the
// square of a linear ramp over the cosine.
SHARED_FN float SpotAttenuation(float cosine, float inner_cosine, float outer_cosine) {
  float ramp = (cosine - outer_cosine) / max(inner_cosine - outer_cosine, 0.001f);
  float clamped = clamp(ramp, 0.0f, 1.0f);
  return clamped * clamped;
}

STILLRAY_RENDER_END

#endif  // STILLRAY_RENDER_PUNCTUAL_SHARED_H
