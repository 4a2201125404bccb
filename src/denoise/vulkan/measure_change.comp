// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require

// limit_history, MeasureChange and the counts of FindMovingLight: see stages/limit_history.h. One
// invocation per block.
#include "denoise/vulkan/common.glsl"
#include "denoise/vulkan/limit_history.glsl"

layout(set = 1, binding = 0) uniform texture2DArray averaged;
layout(set = 1, binding = 1, LIGHT_FORMAT) writeonly uniform image2DArray change_out;

shared uint changed_here[4];
shared uint known_here[4];

void MeasureBlock(ivec2 block) {
  for (int s = 0; s < SignalCount(); ++s) {
    ivec3 at = ivec3(block, s);
    vec4 light = texelFetch(averaged, at, 0);
    bool valid = IsValid(light.w);
    float change = valid ? kChangeScale * LogChange(light.x, light.y) : 0.0f;
    imageStore(change_out, at,
               Stored(vec4(change, change * change, 0.0f, PackDeviation(1.0f, valid))));
    if (valid) {
      atomicAdd(known_here[s], 1u);
      atomicAdd(changed_here[s], HasChanged(light.x, light.y, VarianceOf(light.w)) ? 1u : 0u);
    }
  }
}

void main() {
  uint i = gl_LocalInvocationIndex;
  if (i < 4u) {
    changed_here[i] = known_here[i] = 0u;
  }
  barrier();
  ivec2 block = ivec2(gl_GlobalInvocationID.xy);
  if (all(lessThan(block, CoarseSize()))) {
    MeasureBlock(block);
  }
  barrier();
  if (i < 4u && known_here[i] != 0u) {
    atomicAdd(known_blocks[i], known_here[i]);
    atomicAdd(changed_blocks[i], changed_here[i]);
  }
}
