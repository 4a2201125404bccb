// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require

// limit_history, CompareWithHistory: see stages/limit_history.h. One invocation per block of 2x2
// pixels. light_out: present, history, deviation of their noise. compressed_out: compressed present
// minus compressed history (the difference, which half precision would lose otherwise), compressed
// history, variance of single compressed samples, deviation of the noise.
#include "denoise/vulkan/common.glsl"
#include "denoise/vulkan/limit_history.glsl"

layout(set = 1, binding = 0) uniform utexture2D surface_image;
layout(set = 1, binding = 1) uniform utexture2D detail_image;
layout(set = 1, binding = 2) uniform texture2DArray noisy;
layout(set = 1, binding = 3) uniform texture2DArray moments;
layout(set = 1, binding = 4) uniform texture2DArray compressed;
layout(set = 1, binding = 5, SURFACE_FORMAT) writeonly uniform uimage2D surface_out;
layout(set = 1, binding = 6, DETAIL_FORMAT) writeonly uniform uimage2D detail_out;
layout(set = 1, binding = 7, LIGHT_FORMAT) writeonly uniform image2DArray light_out;
layout(set = 1, binding = 8, LIGHT_FORMAT) writeonly uniform image2DArray compressed_out;

#include "denoise/vulkan/coarse_grid.glsl"

void CompareSignal(ivec2 block, int s, vec4 weight, vec4 roughness) {
  vec4 sum = vec4(0.0f);             // present, history, noise; weight
  vec4 sum_compressed = vec4(0.0f);  // difference, history, single, noise
  float scale = compressed_scale[s] * exposure[s];
  [[unroll]] for (int k = 0; k < 4; ++k) {
    ivec3 at = ivec3(PixelOf(block, k), s);
    float w = weight[k];
    if (!(w > 0.0f)) {
      continue;
    }
    vec4 light = texelFetch(noisy, at, 0);
    vec4 m = texelFetch(moments, at, 0);
    if (!(light.w > 0.0f) || !(m.z > 0.0f)) {
      continue;
    }
    float variance = VarianceOf(m.y);
    float then = texelFetch(compressed, at, 0).x;
    float single = CompressedVariance(then, m.x, variance, scale);
    float noise = ComparisonNoise(light.x, light.w, m.z, m.x, variance, m.w);
    sum += vec4(w * light.x, w * m.x, w * w * noise, w);
    float change = CompressLuminance(light.x, scale) - then;
    float share = ShareOfChange(roughness[k], m.z);
    float spread = SpreadOfDifference(light.w, m.w);
    sum_compressed += vec4(w * change, w * then, w * SingleVariance(change, single, m.z, spread),
                           w * w * CompressedNoise(change, single, spread, share));
  }
  bool valid = sum.w > kLeastComparedWeight;
  float inverse = valid ? 1.0f / sum.w : 0.0f;
  sum *= inverse;
  sum_compressed *= inverse;
  imageStore(light_out, ivec3(block, s),
             Stored(vec4(sum.xy, 0.0f, PackDeviation(sum.z * inverse, valid))));
  imageStore(compressed_out, ivec3(block, s),
             Stored(vec4(sum_compressed.xy, sum_compressed.z * kSingleScale,
                         PackDeviation(sum_compressed.w * inverse, valid))));
}

void main() {
  ivec2 block = ivec2(gl_GlobalInvocationID.xy);
  if (any(greaterThanEqual(block, CoarseSize()))) {
    return;
  }
  Block found = FindBlock(block);
  vec4 roughness = vec4(0.0f);
  [[unroll]] for (int k = 0; k < 4 && limit_history.has_roughness != 0; ++k) {
    roughness[k] = texelFetch(roughness_image, min(PixelOf(block, k), Size() - 1), 0).x;
  }
  for (int s = 0; s < SignalCount(); ++s) {
    CompareSignal(block, s, found.weight, roughness);
  }
  StoreBlock(block, found);
}
