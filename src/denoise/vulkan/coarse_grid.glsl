// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Blocks of 2x2 pixels, see stages/coarse_grid.h. The including shader declares surface_image and
// detail_image of the pixels, and surface_out and detail_out of the blocks.
struct Block {
  Surface surface;  // at the block's centre
  vec2 gradient;    // over one pixel
  vec4 weight;      // of the four pixels
};

ivec2 PixelOf(ivec2 block, int k) {
  return 2 * block + ivec2(k & 1, k >> 1);
}

Surface SurfaceAt(ivec2 p) {
  return Inside(p) ? UnpackSurface(texelFetch(surface_image, p, 0)) : Surface(0.0f, vec3(0.0f));
}

Block FindBlock(ivec2 block) {
  Surface nearest = SurfaceAt(PixelOf(block, 0));
  int own = 0;
  [[unroll]] for (int k = 1; k < 4; ++k) {
    Surface other = SurfaceAt(PixelOf(block, k));
    if (other.inverse_depth > nearest.inverse_depth) {
      nearest = other;
      own = k;
    }
  }
  vec2 from = vec2(own & 1, own >> 1);
  Detail detail =
      UnpackDetail(texelFetch(detail_image, PixelOf(block, own), 0), nearest.inverse_depth);
  vec4 weight = vec4(0.0f);
  [[unroll]] for (int k = 0; k < 4; ++k) {
    Surface other = SurfaceAt(PixelOf(block, k));
    if (nearest.inverse_depth > 0.0f && other.inverse_depth > 0.0f) {
      float expected = nearest.inverse_depth + dot(detail.gradient, vec2(k & 1, k >> 1) - from);
      weight[k] = ComparedWeight(dot(nearest.normal, other.normal), expected, other.inverse_depth,
                                 nearest.inverse_depth);
    }
  }
  float centre = nearest.inverse_depth + dot(detail.gradient, vec2(0.5f) - from);
  return Block(Surface(centre > 0.0f ? centre : nearest.inverse_depth, nearest.normal),
               detail.gradient, weight);
}

void StoreBlock(ivec2 block, Block found) {
  imageStore(surface_out, block, PackSurface(found.surface));
  imageStore(detail_out, block,
             PackDetail(Detail(2.0f * found.gradient, 0u), found.surface.inverse_depth));
}
