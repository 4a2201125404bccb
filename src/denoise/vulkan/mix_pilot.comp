// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require

// The pilot estimate: the mean of a pixel's neighbourhood, mixed with its own light for longer
// histories.
#include "denoise/vulkan/common.glsl"
#include "denoise/stages/estimate_variance_shared.h"

layout(set = 1, binding = 0) uniform texture2DArray light;
layout(set = 1, binding = 1) uniform texture2DArray mean;
layout(set = 1, binding = 2) uniform texture2DArray moments;
layout(set = 1, binding = 3, LIGHT_FORMAT) writeonly uniform image2DArray pilot_out;

layout(push_constant) uniform Push {
  int with_pilot;  // bit s: of signal s; others keep their light
};

void main() {
  ivec2 p = ivec2(gl_GlobalInvocationID.xy);
  if (!Inside(p)) {
    return;
  }
  for (int s = 0; s < signals; ++s) {
    ivec3 at = ivec3(p, s);
    vec4 own = texelFetch(light, at, 0);
    vec4 m = texelFetch(mean, at, 0);
    float share = (with_pilot >> s & 1) != 0 ? PilotShare(texelFetch(moments, at, 0).z,
                                                          estimate_variance.short_history_length)
                                             : 0.0f;
    float variance = PilotVariance(VarianceOf(own.w), VarianceOf(m.w), share);
    imageStore(
        pilot_out, at,
        Stored(vec4(own.xyz + share * (m.xyz - own.xyz), PackDeviation(variance, IsValid(own.w)))));
  }
}
