// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// What a surface has beyond metallic-roughness and transmission, at one point.
#ifndef STILLRAY_RENDER_LAYERS_SHARED_H
#define STILLRAY_RENDER_LAYERS_SHARED_H

#ifdef __cplusplus
#include "render/shared.h"
#endif

STILLRAY_RENDER_BEGIN

struct SurfaceLayers {
  vec3 specular_colour;  // of a dielectric's reflectance at normal incidence; may be above 1
  float specular;        // weight of a dielectric's reflection
  vec3 coat_normal;      // of the clear coat, in the surface's local frame
  float coat;            // its weight
  float coat_alpha;      // of GGX, from its roughness
  vec3 sheen_colour;
  float sheen_roughness;
  vec3 through_colour;  // of diffuse transmission
  float through;        // its part of the diffuse light
  float anisotropy;     // strength, 0 to 1
  vec2 tangent;         // in which the reflection is stretched, unit length, in the local frame
  float film;           // weight of the thin film
  float film_ior;
  float film_thickness;  // nm
};

SHARED_FN SurfaceLayers NoLayers() {
  SurfaceLayers layers;
  layers.specular_colour = vec3(1.0f);
  layers.specular = 1.0f;
  layers.coat_normal = vec3(0.0f, 0.0f, 1.0f);
  layers.coat = 0.0f;
  layers.coat_alpha = 0.0f;
  layers.sheen_colour = vec3(0.0f);
  layers.sheen_roughness = 0.0f;
  layers.through_colour = vec3(1.0f);
  layers.through = 0.0f;
  layers.anisotropy = 0.0f;
  layers.tangent = vec2(1.0f, 0.0f);
  layers.film = 0.0f;
  layers.film_ior = 1.3f;
  layers.film_thickness = 0.0f;
  return layers;
}

// Solids have their covering layers on the outside alone.
SHARED_FN void RemoveCovers(SHARED_INOUT(SurfaceLayers) layers) {
  layers.coat = 0.0f;
  layers.sheen_colour = vec3(0.0f);
}

STILLRAY_RENDER_END

#endif  // STILLRAY_RENDER_LAYERS_SHARED_H
