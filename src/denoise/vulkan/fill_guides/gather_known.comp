// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require

// fill_guides, GatherKnown for geometry and motion: from this frame, else held guides along the
// motion; downsampled to the first level. One invocation per cell.
#define CELLS_BINDING 7
#include "denoise/vulkan/common.glsl"
#include "denoise/vulkan/fill_guides/held_guides.glsl"
#include "denoise/vulkan/fill_guides/pyramid.glsl"

layout(set = 1, binding = 0) uniform texture2D depth_before;
layout(set = 1, binding = 1) uniform texture2D normal_before;  // w: known
layout(set = 1, binding = 2) uniform utexture2D id_before;
layout(set = 1, binding = 3, r32f) writeonly uniform image2D depth_out;
layout(set = 1, binding = 4, LIGHT_FORMAT) writeonly uniform image2D normal_out;
layout(set = 1, binding = 5, r32ui) writeonly uniform uimage2D id_out;
layout(set = 1, binding = 6, rg32f) writeonly uniform image2D motion_out;
layout(set = 1, binding = 8, std430) readonly buffer Rejected {
  uint rejected[];
};

struct Guide {
  float depth;
  vec3 normal;
  uint id;
  bool known;
};

Guide Gather(ivec2 p, vec2 motion) {
  if (IsKnown(p)) {
    return Guide(texelFetch(depth_image, p, 0).x, texelFetch(normal_image, p, 0).xyz,
                 has_id != 0 ? texelFetch(id_image, p, 0).x : 0u, true);
  }
  ivec2 q;
  if (FindHeld(p, motion, q)) {
    vec4 normal = texelFetch(normal_before, q, 0);
    if (normal.w != 0.0f && rejected[q.y * width + q.x] != ghost_stamp) {
      return Guide(texelFetch(depth_before, q, 0).x, normal.xyz,
                   has_id != 0 ? texelFetch(id_before, q, 0).x : 0u, true);
    }
  }
  return Guide(0.0f, vec3(0.0f), 0u, false);
}

void main() {
  ivec2 p = ivec2(gl_GlobalInvocationID.xy);
  Level level = FirstLevel();
  if (!Covers(level, p)) {
    return;
  }
  SurfaceMean surface = NoSurfaceMean();
  Mean normal = NoMean();
  for (int i = 0; i < kPyramidFactor * kPyramidFactor; ++i) {
    int column = i % kPyramidFactor;
    ivec2 q = p * kPyramidFactor + ivec2(column, i / kPyramidFactor);
    if (!Inside(q)) {
      continue;
    }
    vec2 motion = vec2(0.0f);
    if (ViewMoves()) {
      motion = IsKnown(q) ? texelFetch(motion_image, q, 0).xy : Upsample(level, kMotionLayer, q).xy;
    }
    Guide g = Gather(q, motion);
    imageStore(depth_out, q, vec4(g.depth));
    imageStore(normal_out, q, Stored(vec4(g.normal, g.known ? 1.0f : 0.0f)));
    if (has_id != 0) {
      imageStore(id_out, q, uvec4(g.id));
    }
    imageStore(motion_out, q, vec4(motion, 0.0f, 0.0f));
    if (g.known) {
      bool is_surface = IsSurface(g.depth);
      Add(surface, column, is_surface ? 1.0f : 0.0f, is_surface ? 1.0f / g.depth : 0.0f, g.id,
          kAny | (is_surface ? kOfSurface : kOfSky));
      if (is_surface) {
        Add(normal, column, g.normal);
      }
    }
  }
  StoreSurface(level, p, surface);
  StoreCell(level, kNormalLayer, p, ValueOf(normal), 0u);
}
