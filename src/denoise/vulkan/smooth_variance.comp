// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require

// SmoothVariance: see stages/prefilter_variance.h. The colour is copied.
#include "denoise/vulkan/common.glsl"
#include "denoise/vulkan/smoothed_variance.glsl"

layout(set = 1, binding = 0) uniform texture2DArray light;
layout(set = 1, binding = 1, LIGHT_FORMAT) writeonly uniform image2DArray light_out;

void main() {
  LoadDeviations(light);
  ivec2 p = ivec2(gl_GlobalInvocationID.xy);
  if (!Inside(p)) {
    return;
  }
  for (int s = 0; s < SignalCount(); ++s) {
    vec4 own = texelFetch(light, ivec3(p, s), 0);
    if (IsValid(own.w)) {
      own.w = PackDeviation(SmoothedVariance(s), true);
    }
    imageStore(light_out, ivec3(p, s), Stored(own));
  }
}
