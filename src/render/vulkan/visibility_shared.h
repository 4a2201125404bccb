// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// How the camera is told to the rasteriser.
#ifndef STILLRAY_RENDER_VULKAN_VISIBILITY_SHARED_H
#define STILLRAY_RENDER_VULKAN_VISIBILITY_SHARED_H

#ifdef __cplusplus
#include "render/vulkan/scene_shared.h"
#endif

STILLRAY_RENDER_BEGIN

// Pushed as constants.
struct RasterView {
  GpuView view;
  vec2 point;  // of each pixel that its ray passes: (0.5, 0.5) is the centre
};

// What lies nearer along the view's axis is cut away. Rays have no such bound, so it is as good as
// none: depths are kNearest / w as floats, whose relative precision is the same everywhere.
const float kNearest = 1e-10f;

STILLRAY_RENDER_END

#endif  // STILLRAY_RENDER_VULKAN_VISIBILITY_SHARED_H
