// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require

// suppress_fireflies, clamp: see stages/suppress_fireflies.h. Computes the sums of luminances
// again.
#include "denoise/vulkan/common.glsl"
#include "denoise/stages/suppress_fireflies_shared.h"
#include "denoise/vulkan/reduce.glsl"

layout(set = 1, binding = 0) uniform texture2DArray noisy;
layout(set = 1, binding = 1, LIGHT_FORMAT) writeonly uniform image2DArray noisy_out;

// Luminance of the brightest neighbour with samples; very large if there is none.
float BrightestNeighbour(ivec2 p, int s) {
  float brightest = -1.0f;
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      ivec2 q = p + ivec2(dx, dy);
      if (Inside(q) && (dx != 0 || dy != 0)) {
        vec4 light = texelFetch(noisy, ivec3(q, s), 0);
        brightest = light.w > 0.0f ? max(brightest, light.x) : brightest;
      }
    }
  }
  return brightest < 0.0f ? 3e38f : brightest;
}

void main() {
  ivec2 p = ivec2(gl_GlobalInvocationID.xy);
  bool inside = Inside(p);
  vec4 luminance = vec4(0.0f);
  for (int s = 0; inside && s < SignalCount(); ++s) {
    vec4 light = texelFetch(noisy, ivec3(p, s), 0);
    light.xyz *= ClampScale(light.x, BrightestNeighbour(p, s));
    luminance += AtComponent(s, light.x);
    imageStore(noisy_out, ivec3(p, s), Stored(light));
  }
  MeasureNewLight(luminance);
}
