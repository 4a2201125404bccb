// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require

// restore_energy, RestoreEnergy: see stages/restore_energy.h.
#include "denoise/vulkan/common.glsl"
#include "denoise/vulkan/limit_history.glsl"
#include "denoise/stages/restore_energy_shared.h"
#include "denoise/stages/select_guides_shared.h"

layout(set = 1, binding = 0) uniform utexture2D surface_image;
layout(set = 1, binding = 1) uniform utexture2D detail_image;
layout(set = 1, binding = 2) uniform utexture2D coarse_surface;
layout(set = 1, binding = 3) uniform texture2DArray averaged;
layout(set = 1, binding = 4) uniform texture2DArray light;
layout(set = 1, binding = 5, LIGHT_FORMAT) writeonly uniform image2DArray light_out;

#include "denoise/vulkan/blocks_around.glsl"

float RatioAt(BlocksAround around, int s) {
  vec2 sum = vec2(0.0f);  // ratio, weight
  [[unroll]] for (int k = 0; k < 4; ++k) {
    if (!(around.weight[k] > 0.0f)) {
      continue;
    }
    vec4 means = texelFetch(averaged, ivec3(around.block[k], s), 0);
    if (IsValid(means.w)) {
      sum += around.weight[k] * vec2(EnergyRatio(means.x, means.y, VarianceOf(means.w)), 1.0f);
    }
  }
  return sum.y > kLeastComparedWeight ? sum.x / sum.y : 1.0f;
}

bool Changes(ivec2 p, int s) {
  bool of_image = (restore_energy.image_signals >> s & 1) != 0;
  return (restore_energy.energy_signals >> s & 1) != 0 &&
         (!of_image || texelFetch(roughness_image, p, 0).x == kRoughnessOfImage);
}

void main() {
  ivec2 p = ivec2(gl_GlobalInvocationID.xy);
  if (!Inside(p)) {
    return;
  }
  Surface surface = UnpackSurface(texelFetch(surface_image, p, 0));
  BlocksAround around = FindBlocksAround(p, surface);
  for (int s = 0; s < SignalCount(); ++s) {
    vec4 own = texelFetch(light, ivec3(p, s), 0);
    if (Changes(p, s)) {
      own.xyz *= RatioAt(around, s);
    }
    imageStore(light_out, ivec3(p, s), Stored(own));
  }
}
