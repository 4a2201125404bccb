// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require

// Sums of the accumulated signals over each workgroup, for the Gaussians of EAW.
#include "denoise/vulkan/common.glsl"
#include "denoise/vulkan/reduce.glsl"

layout(set = 1, binding = 0) uniform texture2DArray colour;

void main() {
  ivec2 p = ivec2(gl_GlobalInvocationID.xy);
  vec4 luminance = SumOfGroup(LuminancesAt(colour, p));
  if (gl_LocalInvocationIndex == 0u) {
    partials[2u * GroupIndex()] = luminance;
  }
}
