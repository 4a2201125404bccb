// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require

// fill_guides, FillHoles: determines whether each hole is a surface, and its geometry.
#define CELLS_BINDING 4
#include "denoise/vulkan/common.glsl"
#include "denoise/vulkan/fill_guides/pyramid.glsl"

layout(set = 1, binding = 0) uniform texture2D normal_now;  // w: known
layout(set = 1, binding = 1, r32f) writeonly uniform image2D depth_out;
layout(set = 1, binding = 2, LIGHT_FORMAT) writeonly uniform image2D normal_out;
layout(set = 1, binding = 3, r32ui) writeonly uniform uimage2D id_out;

void main() {
  ivec2 p = ivec2(gl_GlobalInvocationID.xy);
  if (!Inside(p) || texelFetch(normal_now, p, 0).w != 0.0f) {
    return;
  }
  Hole hole = HoleAt(p);
  Level level = FirstLevel();
  float depth = hole.is_surface ? 1.0f / hole.inverse_depth : uintBitsToFloat(0x7f800000u);
  vec3 normal = hole.is_surface ? Upsample(level, kNormalLayer, p) : vec3(0.0f);
  uint id = hole.is_surface ? LoadCell(level, kSurfaceLayer, p / kPyramidFactor).z : 0u;
  imageStore(depth_out, p, vec4(depth));
  imageStore(normal_out, p, Stored(vec4(normal, 0.0f)));
  if (has_id != 0) {
    imageStore(id_out, p, uvec4(id));
  }
}
