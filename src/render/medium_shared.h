// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Scattering in homogeneous media: KHR_materials_volume_scatter.
#ifndef STILLRAY_RENDER_MEDIUM_SHARED_H
#define STILLRAY_RENDER_MEDIUM_SHARED_H

#ifdef __cplusplus
#include "render/geometry_shared.h"
#endif

STILLRAY_RENDER_BEGIN

// Maximum number of medium collisions of a path. An infinitely deep body of albedo 0.995
// (multi-scatter colour 0.85) loses 0.7% of its light by this limit.
const int kMaxCollisions = 256;
// Collisions before Russian roulette starts.
const int kRouletteCollisions = 3;

// Single-scattering albedo from the multi-scatter albedo of a thick body, as the extension defines
// it: the inverse of van de Hulst's albedo of a half space, (1 - s) (1 - 0.139 s) / (1 + 1.17 s)
// with s = sqrt(1 - albedo).
SHARED_FN float SingleScatterAlbedo(float multi) {
  float s =
      4.09712f + 4.20863f * multi - sqrt(9.59217f + 41.6808f * multi + 17.7126f * multi * multi);
  return clamp(1.0f - s * s, 0.0f, 1.0f);
}

// A sampled free path through a medium.
struct Flight {
  float distance;
  vec3 weight;  // throughput factor for the collision, or for passing the medium
  int collides;
};

// Samples the free path by the extinction of one colour channel, selected in proportion to `share`.
// All channels are weighted by the balance heuristic over that selection (Veach 1997), which bounds
// the weight of a channel by 1 / share.
// \param extinction  per unit length; \param albedo  SingleScatterAlbedo
// \param share       relative throughput of the colour channels; not negative
// \param far         distance to the end of the medium
SHARED_FN Flight FlyThrough(vec3 extinction, vec3 albedo, vec3 share, float far, float u0,
                            float u1) {
  float sum = share.x + share.y + share.z;
  vec3 pick = sum > 0.0f ? share / sum : vec3(1.0f / 3.0f);
  float chosen = u0 < pick.x ? extinction.x : (u0 < pick.x + pick.y ? extinction.y : extinction.z);
  const float kFar = 1e30f;  // 0 times infinity is NaN
  float end = min(far, kFar);
  Flight flight;
  flight.distance = chosen > 0.0f ? -log(1.0f - u1) / chosen : kFar;
  flight.collides = flight.distance < end ? 1 : 0;
  if (flight.collides != 0) {
    vec3 density = extinction * exp(-extinction * flight.distance);
    flight.weight = albedo * density / max(dot(pick, density), 1e-30f);
  } else {
    vec3 passed = exp(-extinction * end);
    flight.weight = passed / max(dot(pick, passed), 1e-30f);
  }
  return flight;
}

// Samples the cosine of the scattering angle of the Henyey-Greenstein (1941) phase function with
// mean cosine g.
SHARED_FN float SampleDeflection(float g, float u) {
  if (abs(g) < 1e-3f) {
    return 1.0f - 2.0f * u;
  }
  float s = (1.0f - g * g) / (1.0f - g + 2.0f * g * u);
  return clamp((1.0f + g * g - s * s) / (2.0f * g), -1.0f, 1.0f);
}

// Samples the scattered direction of light that travels along `direction`.
SHARED_FN vec3 SampleScattering(vec3 direction, float g, float u0, float u1) {
  float cosine = SampleDeflection(g, u0);
  float sine = sqrt(max(1.0f - cosine * cosine, 0.0f));
  vec2 turn = CosSinOfTurn(u1);
  LocalFrame frame = MakeLocalFrame(direction);
  return normalize(ToWorld(frame, vec3(sine * turn.x, sine * turn.y, cosine)));
}

STILLRAY_RENDER_END

#endif  // STILLRAY_RENDER_MEDIUM_SHARED_H
