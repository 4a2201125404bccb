// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Material layers beyond metallic-roughness and transmission, evaluated at one surface point.
#ifndef STILLRAY_RENDER_LAYERS_SHARED_H
#define STILLRAY_RENDER_LAYERS_SHARED_H

#ifdef __cplusplus
#include "render/shared.h"
#endif

STILLRAY_RENDER_BEGIN

struct SurfaceLayers {
  vec3 specular_colour;  // factor of the dielectric F0; may be above 1
  float specular;        // weight of a dielectric's reflection
  vec3 coat_normal;      // clear coat normal in the local frame of the surface
  float coat;            // weight of the clear coat
  float coat_alpha;      // GGX alpha of the clear coat
  vec3 sheen_colour;
  float sheen_roughness;
  vec3 through_colour;  // colour of diffuse transmission
  float through;        // fraction of the diffuse light that is transmitted
  float anisotropy;     // strength, 0 to 1
  vec2 tangent;         // unit direction along which the lobe is stretched, local frame
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

// Removes coat and sheen, which solids have only on the outside.
SHARED_FN void RemoveCovers(SHARED_INOUT(SurfaceLayers) layers) {
  layers.coat = 0.0f;
  layers.sheen_colour = vec3(0.0f);
}

STILLRAY_RENDER_END

#endif  // STILLRAY_RENDER_LAYERS_SHARED_H
