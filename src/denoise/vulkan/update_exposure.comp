// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require

// Chooses the powers of two that light is stored with and the limit of negative light (one
// workgroup), and clears the counts.
#define LOCAL_SIZE_X 256
#define LOCAL_SIZE_Y 1
#include "denoise/vulkan/common.glsl"
#include "denoise/vulkan/exposure_shared.h"
#include "denoise/vulkan/reduce.glsl"

layout(push_constant) uniform Push {
  uint groups;
};

shared uint bins[STILLRAY_LIGHT_BINS];

// As in negative_limit.cpp.
float MeanLight() {
  uint measured = 0u;
  for (int bin = 0; bin < STILLRAY_LIGHT_BINS; ++bin) {
    measured += bins[bin];
  }
  uint brightest = BrightestPixels(measured);
  uint waiting = 0u;  // pixels that count as the next ones do
  uint passed = 0u;
  int dimmest = 0;
  float sum = 0.0f;
  for (int bin = STILLRAY_LIGHT_BINS - 1; bin > 0; --bin) {
    uint count = bins[bin];
    dimmest = count != 0u ? bin : dimmest;
    passed += count;
    waiting += count;
    if (passed > brightest) {
      sum += float(waiting) * LightOfBin(bin);
      waiting = 0u;
    }
  }
  sum += float(waiting) * LightOfBin(dimmest);
  return measured > 0u ? sum / float(measured) : 0.0f;
}

void main() {
  for (uint i = gl_LocalInvocationIndex; i < STILLRAY_LIGHT_BINS; i += 256u) {
    bins[i] = light_bins[i];
    light_bins[i] = 0u;
  }
  vec4 light = vec4(0.0f);
  vec4 other = vec4(0.0f);
  for (uint i = gl_LocalInvocationIndex; i < groups; i += 256u) {
    light += partials[2u * i];
    other += partials[2u * i + 1u];
  }
  light = SumOfGroup(light);
  other = SumOfGroup(other);
  if (gl_LocalInvocationIndex != 0u) {
    return;
  }
  float brightness = other.x / max(other.z, 1.0f);
  for (int s = 0; s < 4; ++s) {
    float mean = light[s] / max(other.y, 1.0f);
    float old = has_history != 0 ? exposure[s] : 0.0f;
    float chosen = ChooseExposure(old, mean);
    exposure[s] = chosen;
    exposure_ratio[s] = old > 0.0f ? chosen / old : 1.0f;
    brightness += mean;
    if (has_history == 0) {
      compressed_scale[s] = 0.0f;
    }
  }
  float old = has_picture != 0 ? picture_exposure : 0.0f;
  picture_exposure = ChooseExposure(old, brightness);
  picture_ratio = old > 0.0f ? picture_exposure / old : 1.0f;
  negative_limit = NegativeLimit(MeanLight());
  non_finite = 0u;
  negative = 0u;
  bad_guides = 0u;
}
