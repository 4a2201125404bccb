// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require

// Converts the second moments of a layer to the albedo that select_guides writes.
#include "denoise/vulkan/layer_images.glsl"
#include "denoise/rescaled_moment_shared.h"

layout(set = 0, binding = 0) uniform texture2D direct;
layout(set = 0, binding = 1) uniform texture2D indirect;
layout(set = 0, binding = 2) uniform texture2D direct_moment;
layout(set = 0, binding = 3) uniform texture2D indirect_moment;
layout(set = 0, binding = 4) uniform texture2D surface_albedo;
layout(set = 0, binding = 5) uniform texture2D selected_albedo;
layout(set = 0, binding = 6, r32f) writeonly uniform image2D direct_out;
layout(set = 0, binding = 7, r32f) writeonly uniform image2D indirect_out;

layout(push_constant) uniform Push {
  int width;
  int height;
};

void main() {
  ivec2 p = ivec2(gl_GlobalInvocationID.xy);
  ivec2 size = ivec2(width, height);
  if (p.x >= size.x || p.y >= size.y) {
    return;
  }
  vec3 before = texelFetch(surface_albedo, p, 0).xyz;
  vec3 after = texelFetch(selected_albedo, p, 0).xyz;
  imageStore(direct_out, p,
             vec4(RescaledMoment(texelFetch(direct_moment, p, 0).x, texelFetch(direct, p, 0).xyz,
                                 before, after)));
  imageStore(indirect_out, p,
             vec4(RescaledMoment(texelFetch(indirect_moment, p, 0).x,
                                 texelFetch(indirect, p, 0).xyz, before, after)));
}
