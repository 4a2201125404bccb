// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Camera parameters for rasterisation.
#ifndef STILLRAY_RENDER_VULKAN_VISIBILITY_SHARED_H
#define STILLRAY_RENDER_VULKAN_VISIBILITY_SHARED_H

#ifdef __cplusplus
#include "render/vulkan/scene_shared.h"
#endif

STILLRAY_RENDER_BEGIN

// Push constants.
struct RasterView {
  GpuView view;
  vec2 point;  // position of the primary ray in the pixel: (0.5, 0.5) is the centre
};

// Distance of the near plane. Rays have no near plane, hence it is negligibly close: depths are
// kNearest / w as floats, whose relative precision is uniform.
const float kNearest = 1e-10f;

STILLRAY_RENDER_END

#endif  // STILLRAY_RENDER_VULKAN_VISIBILITY_SHARED_H
