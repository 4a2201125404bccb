// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require

// The luminances that limit_history compresses with (one workgroup): see CompressionScale.
#define LOCAL_SIZE_X 256
#define LOCAL_SIZE_Y 1
#include "denoise/vulkan/common.glsl"
#include "denoise/vulkan/reduce.glsl"
#include "denoise/stages/limit_history_shared.h"

layout(push_constant) uniform Push {
  uint groups;
};

void main() {
  vec4 sum = SumOfPartials(groups, has_history != 0 ? 1u : 0u);
  if (gl_LocalInvocationIndex == 0u) {
    for (int s = 0; s < 4; ++s) {
      float mean = sum[s] / (float(width) * float(height)) / exposure[s];
      old_compressed_scale[s] = compressed_scale[s];
      compressed_scale[s] = CompressionScale(compressed_scale[s], max(mean, 1e-20f));
    }
  }
}
