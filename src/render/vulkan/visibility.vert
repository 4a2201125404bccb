// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450

// Draws the triangles of one instance for the camera; gl_InstanceIndex is its index.
#include "render/vulkan/scene.glsl"
#include "render/vulkan/visibility_shared.h"

layout(push_constant) uniform Push {
  RasterView raster;
};

layout(location = 0) flat out uvec2 triangle;

void main() {
  GpuInstance instance = instances[gl_InstanceIndex];
  uint primitive = uint(gl_VertexIndex) / 3u;
  uint corner = words[instance.indices + uint(gl_VertexIndex)];
  vec3 p = TransformPoint(instance.world_x, instance.world_y, instance.world_z,
                          Vec3At(instance.positions + 3u * corner));
  vec3 offset = p - raster.view.position;
  float depth = dot(offset, raster.view.forward);
  float x = dot(offset, raster.view.right) / raster.view.half_width;
  float y = -dot(offset, raster.view.up) / raster.view.half_height;
  // Shifts the sample at a pixel's centre to the camera ray through `point`.
  vec2 shift = (vec2(1.0f) - 2.0f * raster.point) / vec2(raster.view.width, raster.view.height);
  gl_Position = vec4(x + shift.x * depth, y + shift.y * depth, kNearest, depth);
  triangle = uvec2(uint(gl_InstanceIndex), primitive);
}
