// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require

// keep_samples and keep_mirrors, after their wavelet levels: see stages/keep_samples.h.
#include "denoise/vulkan/common.glsl"
#include "denoise/vulkan/sample_squares.glsl"
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
    if (IsValid(m.w) && m.x > m.y) {
      vec3 kept = texelFetch(noisy, at, 0).xyz;
      float deviation = kDifferenceScale * abs(kept.x - c.x);
      float share = ShareOfFiltered(m.x, m.y, deviation, keep_samples.kept_reach);
      c.xyz = kept + share * (c.xyz - kept);
    }
    imageStore(light_out, at, Stored(c));
  }
}
