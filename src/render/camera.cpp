// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "render/camera.h"

#include <cmath>

#include "render/geometry_shared.h"

namespace stillray::render {

CameraView CameraView::Through(vec2 lens) const {
  CameraView view = *this;
  const vec2 offset = lens * lens_radius;
  view.position += right * offset.x + up * offset.y;
  view.shift = offset * inverse_focus;
  return view;
}

vec3 CameraView::Direction(vec2 pixel) const {
  const float x = (2.0f * pixel.x / width - 1.0f) * half_width - shift.x;
  const float y = (1.0f - 2.0f * pixel.y / height) * half_height - shift.y;
  return normalize(forward + right * x + up * y);
}

vec2 CameraView::Project(vec3 offset) const {
  constexpr float kNearest = 1e-20f;  // prevents division by zero for points in the camera plane
  const float depth = dot(offset, forward);
  const float safe = std::copysign(max(std::abs(depth), kNearest), depth);
  const float x = dot(offset, right) / (safe * half_width) + shift.x / half_width;
  const float y = dot(offset, up) / (safe * half_height) + shift.y / half_height;
  return {(x + 1.0f) * 0.5f * width, (1.0f - y) * 0.5f * height};
}

float CameraView::Depth(vec3 point) const {
  return dot(point - position, forward);
}

CameraView MakeCameraView(const Camera& camera, const mat4& world, int width, int height) {
  CameraView view;
  view.position = vec3(world[3]);
  view.forward = SafeNormalize(-vec3(world[2]), vec3(0.0f, 0.0f, -1.0f));
  // Orthogonalised, in case the node is sheared or mirrored.
  const vec3 up = SafeNormalize(vec3(world[1]), vec3(0.0f, 1.0f, 0.0f));
  view.right = SafeNormalize(cross(view.forward, up), MakeLocalFrame(view.forward).x);
  view.up = cross(view.right, view.forward);
  view.width = static_cast<float>(width);
  view.height = static_cast<float>(height);
  view.half_height = std::tan(0.5f * camera.yfov);
  view.half_width = view.half_height * view.width / view.height;
  return view;
}

}  // namespace stillray::render
