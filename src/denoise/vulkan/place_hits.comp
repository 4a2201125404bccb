// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require

// Before select_guides: depth and motion of virtual images, from hit distances. See
// stillray/reflections.h. Reads 8, writes 12 bytes per pixel.
#include "denoise/vulkan/layer_images.glsl"
#include "core/hit_distance_shared.h"

layout(set = 0, binding = 0) uniform texture2D surface_depth;
layout(set = 0, binding = 1) uniform texture2D hit_distance;
layout(set = 0, binding = 2, r32f) writeonly uniform image2D depth_out;
layout(set = 0, binding = 3, rg32f) writeonly uniform image2D motion_out;

layout(push_constant) uniform Push {
  HitCamera camera;
};

void main() {
  ivec2 p = ivec2(gl_GlobalInvocationID.xy);
  if (p.x >= camera.width || p.y >= camera.height) {
    return;
  }
  vec2 place = PlaceOfPixel(camera, p.x, p.y);
  float depth = DepthOfHit(texelFetch(surface_depth, p, 0).x, texelFetch(hit_distance, p, 0).x,
                           CosineOfRay(camera, place));
  vec2 motion = depth > 0.0f ? MotionOfHit(camera, place, depth) : vec2(0.0f);
  imageStore(depth_out, p, vec4(depth));
  imageStore(motion_out, p, vec4(motion, 0.0f, 0.0f));
}
