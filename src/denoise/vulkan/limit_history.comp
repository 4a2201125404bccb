// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require

// limit_history, LimitHistory: see stages/limit_history.h. Writes the ratio and the relative bias
// of each pixel; accumulate computes the length.
#include "denoise/vulkan/common.glsl"
#include "denoise/vulkan/limit_history.glsl"

layout(set = 1, binding = 0) uniform utexture2D surface_image;
layout(set = 1, binding = 1) uniform utexture2D detail_image;
layout(set = 1, binding = 2) uniform utexture2D coarse_surface;
layout(set = 1, binding = 3) uniform texture2DArray blurred;
layout(set = 1, binding = 4) uniform texture2DArray fine_blurred;
layout(set = 1, binding = 5) uniform texture2DArray ratio_image;
layout(set = 1, binding = 6) uniform texture2DArray noisy;
layout(set = 1, binding = 7, LIGHT_FORMAT) writeonly uniform image2DArray compared_out;

#include "denoise/vulkan/blocks_around.glsl"

// RelativeBias of a block after one of the levels.
float BiasOf(vec4 level, float dead) {
  return RelativeBias(level.x, VarianceOf(level.w), level.z / kSingleScale, dead);
}

void main() {
  ivec2 p = ivec2(gl_GlobalInvocationID.xy);
  if (!Inside(p)) {
    return;
  }
  Surface surface = UnpackSurface(texelFetch(surface_image, p, 0));
  BlocksAround around = FindBlocksAround(p, surface);
  for (int s = 0; s < SignalCount(); ++s) {
    ivec3 at = ivec3(p, s);
    float n = texelFetch(noisy, at, 0).w;
    bool has_samples = surface.inverse_depth > 0.0f && n > 0.0f;
    float dead = DeadZone(limit_history.limit_dead, MovingLightOf(s));
    bool is_fine = (limit_history.fine_signals >> s & 1) != 0;
    vec3 sum = vec3(0.0f);  // ratio, bias, weight
    [[unroll]] for (int k = 0; k < 4; ++k) {
      if (!(around.weight[k] > 0.0f)) {
        continue;
      }
      ivec3 block = ivec3(around.block[k], s);
      vec4 c = texelFetch(blurred, block, 0);
      if (IsValid(c.w)) {
        float bias = BiasOf(c, dead);
        if (is_fine) {
          bias = max(bias, BiasOf(texelFetch(fine_blurred, block, 0), kFineDead * dead));
        }
        sum += around.weight[k] * vec3(texelFetch(ratio_image, block, 0).x, bias, 1.0f);
      }
    }
    bool similar = has_samples && sum.z > kLeastComparedWeight;
    vec2 result = similar ? sum.xy / sum.z : vec2(1.0f, 0.0f);
    result.y = BiasOfFrame(result.y, n);
    imageStore(compared_out, at, Stored(vec4(result, 0.0f, 0.0f)));
  }
}
