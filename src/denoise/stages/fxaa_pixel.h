// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// One pixel of fxaa: the scalar version, which the SIMD version also uses at the ends of rows.
#pragma once

#include <algorithm>
#include <cmath>

#include "denoise/stages/fxaa_shared.h"
#include "stillray/image.h"

namespace stillray {

/// Offset and share of the neighbour that a pixel is blended with.
struct FxaaStep {
  int dx = 0;
  int dy = 0;
  float share = 0;
};

/// \param luma  luminance of the image, >= 0: an Image1, or a type with the same access
template <typename Luma>
FxaaStep FindFxaaStep(const Luma& luma, int x, int y) {
  const int width = luma.width();
  const int height = luma.height();
  const auto at = [&](int px, int py) {
    return luma(std::clamp(px, 0, width - 1), std::clamp(py, 0, height - 1));
  };
  const float m = luma(x, y);
  const float n = at(x, y - 1);
  const float s = at(x, y + 1);
  const float w = at(x - 1, y);
  const float e = at(x + 1, y);
  if (!IsEdge(std::min({m, n, s, w, e}), std::max({m, n, s, w, e}))) {
    return {};
  }
  // Second differences across rows and columns determine the direction of the edge.
  const float rows = std::abs(n + s - 2 * m) * 2 +
                     std::abs(at(x - 1, y - 1) + at(x - 1, y + 1) - 2 * w) +
                     std::abs(at(x + 1, y - 1) + at(x + 1, y + 1) - 2 * e);
  const float columns = std::abs(w + e - 2 * m) * 2 +
                        std::abs(at(x - 1, y - 1) + at(x + 1, y - 1) - 2 * n) +
                        std::abs(at(x - 1, y + 1) + at(x + 1, y + 1) - 2 * s);
  const bool along_x = rows >= columns;
  const float before = along_x ? n : w;
  const float after = along_x ? s : e;
  const int side = std::abs(before - m) >= std::abs(after - m) ? -1 : 1;
  const float other = side < 0 ? before : after;
  const float step = std::abs(other - m);
  const float middle = 0.5f * (other + m);
  // Mean of the two rows of the edge, d pixels along it: it differs from the middle where the step
  // ends.
  const auto across = [&](int d) {
    const float here = along_x ? at(x + d, y) : at(x, y + d);
    const float there = along_x ? at(x + d, y + side) : at(x + side, y + d);
    return 0.5f * (here + there) - middle;
  };
  int reach[2] = {kFxaaReach, kFxaaReach};
  float end[2] = {0, 0};
  for (int k = 0; k < 2; ++k) {
    for (int d = 1; d <= kFxaaReach; ++d) {
      const float difference = across(k == 0 ? -d : d);
      if (std::abs(difference) >= 0.25f * step) {
        reach[k] = d;
        end[k] = difference;
        break;
      }
    }
  }
  const int nearer = reach[0] <= reach[1] ? 0 : 1;
  // Beyond the nearer end both rows must match the other side, or the edge bends away.
  if (end[nearer] == 0 || (end[nearer] > 0) != (other > m)) {
    return {};
  }
  const float share = AcrossShare(static_cast<float>(reach[nearer]) - 0.5f,
                                  static_cast<float>(reach[1 - nearer]) - 0.5f);
  return {along_x ? 0 : side, along_x ? side : 0, share};
}

template <typename Luma>
void FxaaPixel(const Image3& colour, const Luma& luma, const Image1* length, int x, int y,
               Image3* out) {
  const float strength = length == nullptr ? 1.0f : FxaaStrength((*length)(x, y));
  const FxaaStep step = strength > 0 ? FindFxaaStep(luma, x, y) : FxaaStep();
  const int qx = std::clamp(x + step.dx, 0, colour.width() - 1);
  const int qy = std::clamp(y + step.dy, 0, colour.height() - 1);
  for (int c = 0; c < 3; ++c) {
    const float own = colour[c](x, y);
    (*out)[c](x, y) =
        step.share > 0 ? own + strength * step.share * (colour[c](qx, qy) - own) : own;
  }
}

}  // namespace stillray
