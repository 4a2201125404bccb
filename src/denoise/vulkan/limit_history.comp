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
layout(set = 1, binding = 4) uniform texture2DArray ratio_image;
layout(set = 1, binding = 5) uniform texture2DArray noisy;
layout(set = 1, binding = 6, LIGHT_FORMAT) writeonly uniform image2DArray compared_out;

void main() {
  ivec2 p = ivec2(gl_GlobalInvocationID.xy);
  if (!Inside(p)) {
    return;
  }
  Surface surface = UnpackSurface(texelFetch(surface_image, p, 0));
  Detail detail = UnpackDetail(texelFetch(detail_image, p, 0), surface.inverse_depth);
  ivec2 blocks[4];
  vec4 weight = vec4(0.0f);
  for (int k = 0; k < 4; ++k) {
    // Its own block, and those beside it on the pixel's side.
    blocks[k] = (p >> 1) + ivec2(k & 1, k >> 1) * (2 * (p & 1) - 1);
    ivec2 b = blocks[k];
    if (any(lessThan(b, ivec2(0))) || any(greaterThanEqual(b, CoarseSize())) ||
        !(surface.inverse_depth > 0.0f)) {
      continue;
    }
    Surface coarse = UnpackSurface(texelFetch(coarse_surface, b, 0));
    vec2 offset = 2.0f * vec2(b) + 0.5f - vec2(p);
    float expected = surface.inverse_depth + dot(detail.gradient, offset);
    weight[k] = ((k & 1) == 0 ? 0.75f : 0.25f) * ((k >> 1) == 0 ? 0.75f : 0.25f) *
                ComparedWeight(dot(surface.normal, coarse.normal), expected, coarse.inverse_depth,
                               surface.inverse_depth);
  }
  for (int s = 0; s < signals; ++s) {
    ivec3 at = ivec3(p, s);
    bool has_samples = surface.inverse_depth > 0.0f && texelFetch(noisy, at, 0).w > 0.0f;
    vec3 sum = vec3(0.0f);  // ratio, bias, weight
    for (int k = 0; k < 4; ++k) {
      if (!(weight[k] > 0.0f)) {
        continue;
      }
      vec4 c = texelFetch(blurred, ivec3(blocks[k], s), 0);
      if (IsValid(c.w)) {
        float bias =
            RelativeBias(c.x, VarianceOf(c.w), c.z / kSingleScale, limit_history.limit_dead);
        sum += weight[k] * vec3(texelFetch(ratio_image, ivec3(blocks[k], s), 0).x, bias, 1.0f);
      }
    }
    bool similar = has_samples && sum.z > kLeastComparedWeight;
    vec2 result = similar ? sum.xy / sum.z : vec2(1.0f, 0.0f);
    imageStore(compared_out, at, Stored(vec4(result, 0.0f, 0.0f)));
  }
}
