// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "denoise/stages/follow_light.h"
#include "denoise/stages/reproject_shared.h"

namespace stillray::reference {
namespace {

/// Whether block (qx, qy) shows the surface of block (x, y).
bool ShowsSurface(const FollowedBlocks& b, int x, int y, int qx, int qy) {
  const vec2 gradient(b.gradient[0](x, y), b.gradient[1](x, y));
  const float expected = b.inverse_depth(x, y) +
                         gradient.x * static_cast<float>(kFollowBlock * (qx - x)) +
                         gradient.y * static_cast<float>(kFollowBlock * (qy - y));
  float cosine = 0;
  for (int c = 0; c < 3; ++c) {
    cosine += b.normal[c](x, y) * b.normal[c](qx, qy);
  }
  return IsSameSurface(expected, b.inverse_depth(qx, qy), gradient, cosine, b.id(x, y),
                       b.id(qx, qy), kFollowDepth, kFollowCosine, true);
}

float RatioOf(const FollowedBlocks& b, int x, int y) {
  float sum = 0;
  float squares = 0;
  float known = 0;
  for (int qy = std::max(y - kFollowRadius, 0);
       qy <= std::min(y + kFollowRadius, b.change.height() - 1); ++qy) {
    for (int qx = std::max(x - kFollowRadius, 0);
         qx <= std::min(x + kFollowRadius, b.change.width() - 1); ++qx) {
      const bool same = ShowsSurface(b, x, y, qx, qy);
      if (!same && std::abs(qx - x) <= 1 && std::abs(qy - y) <= 1) {
        return 1;
      }
      if (same) {
        const float change = b.change(qx, qy);
        sum += change;
        squares += change * change;
        known += b.known(qx, qy);
      }
    }
  }
  return std::exp(FollowedChange(sum, squares, known));
}

}  // namespace

void FollowLight(const FollowedBlocks& blocks, Image1* ratio) {
  for (int y = 0; y < ratio->height(); ++y) {
    for (int x = 0; x < ratio->width(); ++x) {
      (*ratio)(x, y) = RatioOf(blocks, x, y);
    }
  }
}

}  // namespace stillray::reference
