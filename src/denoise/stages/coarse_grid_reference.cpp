// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "core/shared.h"
#include "denoise/stages/coarse_grid.h"
#include "denoise/stages/limit_history_shared.h"

namespace stillray::reference {
namespace {

/// The inverse depth of a pixel's plane at an offset of `dx`, `dy` pixels.
float ExpectedAt(const GuidePlanes& g, int x, int y, float dx, float dy) {
  return g.inverse_depth(x, y) + (g.gradient[0](x, y) * dx + g.gradient[1](x, y) * dy);
}

}  // namespace

Block BlockAt(const GuidePlanes& g, int bx, int by) {
  Block block = {2 * bx, 2 * by, {}};
  for (int k = 1; k < 4; ++k) {
    const int x = 2 * bx + (k & 1);
    const int y = 2 * by + (k >> 1);
    if (g.inverse_depth(x, y) > g.inverse_depth(block.x, block.y)) {
      block.x = x;
      block.y = y;
    }
  }
  const float own = g.inverse_depth(block.x, block.y);
  for (int k = 0; k < 4 && own > 0; ++k) {
    const int x = 2 * bx + (k & 1);
    const int y = 2 * by + (k >> 1);
    const float found = g.inverse_depth(x, y);
    const float expected = ExpectedAt(g, block.x, block.y, static_cast<float>(x - block.x),
                                      static_cast<float>(y - block.y));
    const float cosine = dot(NormalAt(g, block.x, block.y), NormalAt(g, x, y));
    block.weight[k] = found > 0 ? ComparedWeight(cosine, expected, found, own) : 0.0f;
  }
  return block;
}

void StoreCoarse(const GuidePlanes& g, const Block& block, int bx, int by, GuidePlanes* coarse) {
  const float own = g.inverse_depth(block.x, block.y);
  const float dx = 2 * static_cast<float>(bx) + 0.5f - static_cast<float>(block.x);
  const float dy = 2 * static_cast<float>(by) + 0.5f - static_cast<float>(block.y);
  const float centre = ExpectedAt(g, block.x, block.y, dx, dy);
  coarse->inverse_depth(bx, by) = centre > 0 ? centre : own;
  const vec3 normal = NormalAt(g, block.x, block.y);
  for (int c = 0; c < 3; ++c) {
    coarse->normal[c](bx, by) = normal[c];
  }
  for (int c = 0; c < 2; ++c) {
    coarse->gradient[c](bx, by) = 2 * g.gradient[c](block.x, block.y);
  }
}

BlocksAround FindBlocksAround(const GuidePlanes& coarse, const GuidePlanes& guides, int x, int y) {
  BlocksAround around = {};
  for (int k = 0; k < 4; ++k) {
    const int bx = x / 2 + ((k & 1) == 0 ? 0 : (x & 1) * 2 - 1);
    const int by = y / 2 + ((k >> 1) == 0 ? 0 : (y & 1) * 2 - 1);
    const float dx = 2 * static_cast<float>(bx) + 0.5f - static_cast<float>(x);
    const float dy = 2 * static_cast<float>(by) + 0.5f - static_cast<float>(y);
    const float cosine = dot(NormalAt(guides, x, y), NormalAt(coarse, bx, by));
    around.x[k] = bx;
    around.y[k] = by;
    around.weight[k] = ((k & 1) == 0 ? 0.75f : 0.25f) * ((k >> 1) == 0 ? 0.75f : 0.25f) *
                       ComparedWeight(cosine, ExpectedAt(guides, x, y, dx, dy),
                                      coarse.inverse_depth(bx, by), guides.inverse_depth(x, y));
  }
  return around;
}

}  // namespace stillray::reference
