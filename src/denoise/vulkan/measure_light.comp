// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require

// Measures the luminance of the new signals, emission and background: sums over each workgroup, of
// every measure_stride-th row and column, and a histogram. update_exposure computes exposures and
// the limit of negative values from them.
#include "denoise/vulkan/common.glsl"
#include "denoise/vulkan/new_light.glsl"
#include "denoise/vulkan/reduce.glsl"

vec3 Unfiltered(ivec2 p) {
  vec3 sum = vec3(0.0f);
  if (has_emission != 0) {
    vec3 light = texelFetch(emission_image, p, 0).xyz;
    sum += IsFinite(light) ? light : vec3(0.0f);
  }
  if (has_background != 0) {
    vec3 light = texelFetch(background_image, p, 0).xyz;
    sum += IsFinite(light) ? light : vec3(0.0f);
  }
  return sum;
}

shared uint bins[STILLRAY_LIGHT_BINS];

// See negative_limit.cpp.
void CountLight(ivec2 p) {
  float brightest = 0.0f;
  [[unroll]] for (int k = 0; k < 6; ++k) {
    if ((lights >> k & 1) != 0) {
      vec3 light = LoadLight(k, p);
      if (!IsFinite(light)) {
        return;
      }
      brightest = max(brightest, max(light.x, max(light.y, light.z)));
    }
  }
  atomicAdd(bins[LightBin(floatBitsToUint(brightest))], 1u);
}

void main() {
  const uint kThreads = LOCAL_SIZE_X * LOCAL_SIZE_Y;
  for (uint i = gl_LocalInvocationIndex; i < STILLRAY_LIGHT_BINS; i += kThreads) {
    bins[i] = 0u;
  }
  barrier();
  ivec2 p = ivec2(gl_GlobalInvocationID.xy) * measure_stride + measure_stride / 2;
  vec4 light = vec4(0.0f);
  vec4 other = vec4(0.0f);  // unfiltered radiance, pixels with samples, pixels
  if (Inside(p)) {
    for (int s = 0; s < SignalCount(); ++s) {
      NewLight new_light = LoadNewLight(s, p, kMostLight);
      light += AtComponent(s, min(max(new_light.colour.x, 0.0f), 1e30f));
    }
    if (GivenSamples(p) > 0.0f) {
      CountLight(p);
    }
    vec3 unfiltered = Unfiltered(p);
    other = vec4(min(max(max(unfiltered.x, max(unfiltered.y, unfiltered.z)), 0.0f), 1e30f),
                 GivenSamples(p) > 0.0f ? 1.0f : 0.0f, 1.0f, 0.0f);
  }
  light = SumOfGroup(light);
  other = SumOfGroup(other);
  if (gl_LocalInvocationIndex == 0u) {
    partials[2u * GroupIndex()] = light;
    partials[2u * GroupIndex() + 1u] = other;
  }
  for (uint i = gl_LocalInvocationIndex; i < STILLRAY_LIGHT_BINS; i += kThreads) {
    if (bins[i] != 0u) {
      atomicAdd(light_bins[i], bins[i]);
    }
  }
}
