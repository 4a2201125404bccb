// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The four blocks around a pixel, see stages/coarse_grid.h. The including shader declares
// detail_image of the pixels and coarse_surface of the blocks.
struct BlocksAround {
  ivec2 block[4];
  vec4 weight;  // 0 outside the grid
};

BlocksAround FindBlocksAround(ivec2 p, Surface surface) {
  Detail detail = UnpackDetail(texelFetch(detail_image, p, 0), surface.inverse_depth);
  BlocksAround around;
  around.weight = vec4(0.0f);
  [[unroll]] for (int k = 0; k < 4; ++k) {
    // The pixel's own block, and the three nearest ones.
    around.block[k] = (p >> 1) + ivec2(k & 1, k >> 1) * (2 * (p & 1) - 1);
    ivec2 b = around.block[k];
    if (any(lessThan(b, ivec2(0))) || any(greaterThanEqual(b, CoarseSize())) ||
        !(surface.inverse_depth > 0.0f)) {
      continue;
    }
    Surface coarse = UnpackSurface(texelFetch(coarse_surface, b, 0));
    vec2 offset = 2.0f * vec2(b) + 0.5f - vec2(p);
    float expected = surface.inverse_depth + dot(detail.gradient, offset);
    around.weight[k] = ((k & 1) == 0 ? 0.75f : 0.25f) * ((k >> 1) == 0 ? 0.75f : 0.25f) *
                       ComparedWeight(dot(surface.normal, coarse.normal), expected,
                                      coarse.inverse_depth, surface.inverse_depth);
  }
  return around;
}
