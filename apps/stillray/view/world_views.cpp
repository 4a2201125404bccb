// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "view/world_views.h"

#include <cmath>

#include "core/pixels.h"
#include "render/camera.h"
#include "render/moment.h"

namespace stillray::view {
namespace {

/// Motion in pixels of a static point in world space, or of a direction of the sky, due to the
/// camera.
vec2 CameraMotion(const render::CameraView& now, const render::CameraView& before, vec3 position,
                  vec3 direction, bool is_surface) {
  if (!is_surface) {
    return before.Project(direction) - now.Project(direction);
  }
  return before.Project(position - before.position) - now.Project(position - now.position);
}

}  // namespace

WorldViews MakeWorldViews(const Frame& frame, const CameraPose& pose,
                          const CameraPose& previous_pose) {
  const Guides& g = frame.guides;
  if (g.depth.empty() || g.motion.empty()) {
    return {};
  }
  const render::CameraView now = render::ViewOf(pose, frame.width, frame.height);
  const render::CameraView before = render::ViewOf(previous_pose, frame.width, frame.height);
  WorldViews views = {Image3(frame.width, frame.height), Image2(frame.width, frame.height)};
  ForEachPixel(frame.width, frame.height, [&](int x, int y) {
    const vec2 pixel(static_cast<float>(x) + 0.5f + frame.jitter_x,
                     static_cast<float>(y) + 0.5f + frame.jitter_y);
    const vec3 direction = now.Direction(pixel);
    const float depth = g.depth(x, y);
    const bool is_surface = depth > 0 && std::isfinite(depth);
    vec3 position(0.0f);
    if (is_surface) {
      position = now.position + direction * (depth / dot(direction, now.forward));
    }
    const vec2 still = CameraMotion(now, before, position, direction, is_surface);
    for (int c = 0; c < 3; ++c) {
      views.position[c](x, y) = position[c];
    }
    for (int c = 0; c < 2; ++c) {
      views.object_motion[c](x, y) = g.motion[c](x, y) - still[c];
    }
  });
  return views;
}

}  // namespace stillray::view
