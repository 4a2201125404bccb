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
};

SHARED_FN SurfaceLayers NoLayers() {
  SurfaceLayers layers;
  layers.specular_colour = vec3(1.0f);
  layers.specular = 1.0f;
  return layers;
}

STILLRAY_RENDER_END

#endif  // STILLRAY_RENDER_LAYERS_SHARED_H
