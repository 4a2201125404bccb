// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require

// Chooses the powers of two that light is stored with (one workgroup), and clears the counts.
#define LOCAL_SIZE_X 256
#define LOCAL_SIZE_Y 1
#include "denoise/vulkan/common.glsl"
#include "denoise/vulkan/exposure_shared.h"
#include "denoise/vulkan/reduce.glsl"

layout(push_constant) uniform Push {
  uint groups;
};

void main() {
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
  non_finite = 0u;
  negative = 0u;
  bad_guides = 0u;
}
