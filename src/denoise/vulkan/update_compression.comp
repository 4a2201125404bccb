// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require

// Chooses the compression scales of limit_history in the first frame (one workgroup): see
// CompressionScale. In later frames update_exposure chooses them.
#define LOCAL_SIZE_X 256
#define LOCAL_SIZE_Y 1
#include "denoise/vulkan/common.glsl"
#include "denoise/vulkan/reduce.glsl"
#include "denoise/stages/limit_history_shared.h"

layout(push_constant) uniform Push {
  uint groups;
};

void main() {
  vec4 sum = SumOfPartials(groups, 0u);
  if (gl_LocalInvocationIndex == 0u) {
    for (int s = 0; s < 4; ++s) {
      float mean = sum[s] / (float(width) * float(height)) / exposure[s];
      compressed_scale[s] = CompressionScale(0.0f, max(mean, 1e-20f));
    }
  }
}
