// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require

// restore_energy, MeasureEnergy: see stages/restore_energy.h. One invocation per block of 2x2
// pixels. Runs before the wavelet, which may overwrite the accumulated signal, and after it.
// light_out: mean of the accumulated signal, mean of the filtered signal, deviation of their
// difference.
#include "denoise/vulkan/common.glsl"
#include "denoise/vulkan/limit_history.glsl"
#include "denoise/stages/restore_energy_shared.h"

layout(set = 1, binding = 0) uniform utexture2D surface_image;
layout(set = 1, binding = 1) uniform utexture2D detail_image;
layout(set = 1, binding = 2) uniform texture2DArray moments;
layout(set = 1, binding = 3) uniform texture2DArray light;
layout(set = 1, binding = 4) uniform texture2DArray begun;  // light_out of the first run
layout(set = 1, binding = 5, SURFACE_FORMAT) writeonly uniform uimage2D surface_out;
layout(set = 1, binding = 6, DETAIL_FORMAT) writeonly uniform uimage2D detail_out;
layout(set = 1, binding = 7, LIGHT_FORMAT) writeonly uniform image2DArray light_out;

layout(push_constant) uniform Push {
  int is_filtered;  // 0: light is the accumulated signal, 1: the filtered signal
};

#include "denoise/vulkan/coarse_grid.glsl"

void MeasureSignal(ivec2 block, int s, vec4 weight) {
  vec2 sum = vec2(0.0f);  // luminance, weight
  [[unroll]] for (int k = 0; k < 4; ++k) {
    ivec3 at = ivec3(PixelOf(block, k), s);
    if (weight[k] > 0.0f && texelFetch(moments, at, 0).z > 0.0f) {
      sum += weight[k] * vec2(texelFetch(light, at, 0).x, 1.0f);
    }
  }
  bool valid = sum.y > kLeastComparedWeight;
  float mean = valid ? sum.x / sum.y : 0.0f;
  float accumulated = is_filtered != 0 ? texelFetch(begun, ivec3(block, s), 0).x : mean;
  imageStore(
      light_out, ivec3(block, s),
      Stored(vec4(accumulated, mean, 0.0f, PackDeviation(EnergyNoise(accumulated, mean), valid))));
}

void main() {
  ivec2 block = ivec2(gl_GlobalInvocationID.xy);
  if (any(greaterThanEqual(block, CoarseSize()))) {
    return;
  }
  Block found = FindBlock(block);
  for (int s = 0; s < SignalCount(); ++s) {
    MeasureSignal(block, s, found.weight);
  }
  StoreBlock(block, found);
}
