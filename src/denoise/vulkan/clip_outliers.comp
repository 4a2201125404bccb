// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require

// clip_outliers: see stages/clip_outliers.h.
#include "denoise/vulkan/common.glsl"
#include "denoise/stages/clip_outliers_shared.h"

layout(set = 1, binding = 0) uniform texture2DArray light;
layout(set = 1, binding = 1, LIGHT_FORMAT) writeonly uniform image2DArray light_out;

vec4 Clipped(ivec2 p, int s) {
  vec4 own = texelFetch(light, ivec3(p, s), 0);
  float lowest = 1e37f;
  float highest = -1e37f;
  vec4 sum = vec4(0.0f);  // colour, count
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      ivec2 q = p + ivec2(dx, dy);
      if (!Inside(q) || (dx == 0 && dy == 0)) {
        continue;
      }
      vec4 other = texelFetch(light, ivec3(q, s), 0);
      if (IsValid(other.w)) {
        lowest = min(lowest, other.x);
        highest = max(highest, other.x);
        sum += vec4(other.xyz, 1.0f);
      }
    }
  }
  bool clips = IsValid(own.w) && sum.w > 0.0f &&
               IsOutlier(own.x, lowest, highest, VarianceOf(own.w), clip_outliers.clip_outliers);
  if (!clips) {
    return own;
  }
  vec3 mean = sum.xyz / sum.w;
  return vec4(mean * ClippedScale(own.x, lowest, highest, mean.x), own.w);
}

void main() {
  ivec2 p = ivec2(gl_GlobalInvocationID.xy);
  if (!Inside(p)) {
    return;
  }
  for (int s = 0; s < SignalCount(); ++s) {
    imageStore(light_out, ivec3(p, s), Stored(Clipped(p, s)));
  }
}
