// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require

// demodulate: see stages/demodulate.h. Includes firefly compression, which is pixel by pixel.
#include "denoise/vulkan/common.glsl"
#include "denoise/vulkan/new_light.glsl"
#include "denoise/vulkan/reduce.glsl"

layout(set = 1, binding = 0, LIGHT_FORMAT) writeonly uniform image2DArray noisy_out;
layout(set = 1, binding = 1, SCALAR_FORMAT) writeonly uniform image2DArray within_out;

void main() {
  ivec2 p = ivec2(gl_GlobalInvocationID.xy);
  bool inside = Inside(p);
  vec4 luminance = vec4(0.0f);
  for (int s = 0; inside && s < SignalCount(); ++s) {
    NewLight light = LoadNewLight(s, p, negative_limit);
    vec3 colour = ClampLight(light.colour * exposure[s]);
    luminance += AtComponent(s, colour.x);
    imageStore(noisy_out, ivec3(p, s), Stored(vec4(colour, min(light.samples, kMostLight))));
    if (second_moments != 0) {
      float within = light.samples > 0.0f ? WithinVariance(s, p) : 0.0f;
      float deviation = min(sqrt(within) * exposure[s], kMostLight);
      imageStore(within_out, ivec3(p, s), vec4(deviation));
    }
    if (light.non_finite) {
      atomicAdd(non_finite, 1u);
    }
    if (light.negative) {
      atomicAdd(negative, 1u);
    }
  }
  MeasureNewLight(luminance);
}
