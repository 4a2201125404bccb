// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require

// Computes the mean luminance of each accumulated signal (one workgroup).
#define LOCAL_SIZE_X 256
#define LOCAL_SIZE_Y 1
#include "denoise/vulkan/common.glsl"
#include "denoise/vulkan/reduce.glsl"

layout(push_constant) uniform Push {
  uint groups;
};

void main() {
  vec4 sum = SumOfPartials(groups, 0u);
  if (gl_LocalInvocationIndex == 0u) {
    for (int s = 0; s < 4; ++s) {
      mean_luminance[s] = max(sum[s] / (float(width) * float(height)) / exposure[s], 1e-20f);
    }
  }
}
