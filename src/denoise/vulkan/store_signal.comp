// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require

// Copies one filtered signal to an image of the caller.
#include "denoise/vulkan/common.glsl"
#include "denoise/vulkan/new_light.glsl"
#include "denoise/vulkan/filtered_light.glsl"

layout(set = 1, binding = 0) uniform texture2DArray light;
layout(set = 1, binding = 1, rgba32f) writeonly uniform image2D float_out;
layout(set = 1, binding = 2, rgba16f) writeonly uniform image2D half_out;

layout(push_constant) uniform Push {
  int signal;
};

void main() {
  ivec2 p = ivec2(gl_GlobalInvocationID.xy);
  if (!Inside(p)) {
    return;
  }
  vec3 rgb = FilteredLight(texelFetch(light, ivec3(p, signal), 0).xyz, signal);
  if (colour_is_half != 0) {
    imageStore(half_out, p, Stored(vec4(clamp(rgb, vec3(-65504.0f), vec3(65504.0f)), 1.0f)));
  } else {
    imageStore(float_out, p, vec4(rgb, 1.0f));
  }
}
