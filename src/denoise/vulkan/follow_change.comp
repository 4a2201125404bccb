// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require

// follow_light, second pass: the ratio of each block, from the changes of the blocks around it.
#include "denoise/vulkan/common.glsl"
#include "denoise/stages/follow_light_shared.h"

layout(set = 1, binding = 0) uniform utexture2D surface_image;
layout(set = 1, binding = 1) uniform utexture2D detail_image;
layout(set = 1, binding = 2) uniform texture2D changes;  // of follow_light.comp
layout(set = 1, binding = 3, r32f) writeonly uniform image2D ratio_out;

ivec2 PixelOf(ivec2 block) {
  return ivec2(FollowPixel(block.x, width), FollowPixel(block.y, height));
}

// The logarithm of the ratio of a block.
float FollowedAt(ivec2 block, ivec2 blocks) {
  ivec2 p = PixelOf(block);
  Surface centre = UnpackSurface(texelFetch(surface_image, p, 0));
  Detail detail = UnpackDetail(texelFetch(detail_image, p, 0), centre.inverse_depth);
  ivec2 first = max(block - kFollowRadius, ivec2(0));
  ivec2 last = min(block + kFollowRadius, blocks - 1);
  float sum = 0.0f;
  float squares = 0.0f;
  float known = 0.0f;
  for (int y = first.y; y <= last.y; ++y) {
    for (int x = first.x; x <= last.x; ++x) {
      ivec2 q = PixelOf(ivec2(x, y));
      ivec2 offset = ivec2(x, y) - block;
      Surface s = UnpackSurface(texelFetch(surface_image, q, 0));
      uint id = UnpackDetail(texelFetch(detail_image, q, 0), s.inverse_depth).id;
      float expected = centre.inverse_depth + dot(detail.gradient, vec2(kFollowBlock * offset));
      bool same =
          IsSameSurface(expected, s.inverse_depth, detail.gradient, dot(centre.normal, s.normal),
                        detail.id, id, kFollowDepth, kFollowCosine, true);
      if (!same && max(abs(offset.x), abs(offset.y)) <= 1) {
        return 0.0f;
      }
      if (same) {
        vec2 found = texelFetch(changes, ivec2(x, y), 0).xy;
        sum += found.x;
        squares += found.x * found.x;
        known += found.y;
      }
    }
  }
  return FollowedChange(sum, squares, known);
}

void main() {
  ivec2 block = ivec2(gl_GlobalInvocationID.xy);
  ivec2 blocks = ivec2(FollowSize(width), FollowSize(height));
  if (any(greaterThanEqual(block, blocks))) {
    return;
  }
  imageStore(ratio_out, block, vec4(exp(FollowedAt(block, blocks))));
}
