// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require

// keep_samples and keep_mirrors, after their wavelet levels: see stages/keep_samples.h.
#include "denoise/vulkan/common.glsl"
#include "denoise/stages/keep_samples_shared.h"

layout(set = 1, binding = 0) uniform texture2DArray noisy;
layout(set = 1, binding = 1) uniform texture2DArray light;
layout(set = 1, binding = 2) uniform texture2DArray measured;
layout(set = 1, binding = 3, LIGHT_FORMAT) writeonly uniform image2DArray light_out;

void main() {
  ivec2 p = ivec2(gl_GlobalInvocationID.xy);
  if (!Inside(p)) {
    return;
  }
  for (int s = 0; s < SignalCount(); ++s) {
    ivec3 at = ivec3(p, s);
    vec4 c = texelFetch(light, at, 0);
    vec4 m = texelFetch(measured, at, 0);
    float share = IsValid(m.w) ? FilteredShare(m.x, m.y) : 1.0f;
    if (share < 1.0f) {
      vec3 kept = texelFetch(noisy, at, 0).xyz;
      c.xyz = kept + share * (c.xyz - kept);
    }
    imageStore(light_out, at, Stored(c));
  }
}
