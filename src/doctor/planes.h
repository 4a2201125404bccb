// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Flat parts of surfaces: neighbourhoods with a constant normal.
#pragma once

#include <cmath>

#include "stillray/frame.h"

namespace stillray::doctor {

/// Whether two normals are equal up to the rounding of halves.
inline bool SameNormal(const Image3& normal, int x, int y, int other_x, int other_y) {
  constexpr float kRounding = 2e-3f;
  float difference = 0;
  for (int c = 0; c < 3; ++c) {
    difference += std::fabs(normal[c](x, y) - normal[c](other_x, other_y));
  }
  return difference <= kRounding;  // false for NaN
}

inline bool IsZeroNormal(const Image3& normal, int x, int y) {
  return normal[0](x, y) == 0 && normal[1](x, y) == 0 && normal[2](x, y) == 0;
}

/// Whether the surface is flat along a line of 2 `reach` + 1 pixels centred on (x, y).
inline bool IsFlat(const Frame& frame, int x, int y, int dx, int dy, int reach) {
  const Guides& g = frame.guides;
  if (x - reach * dx < 0 || y - reach * dy < 0 || x + reach * dx >= frame.width ||
      y + reach * dy >= frame.height || IsZeroNormal(g.normal, x, y)) {
    return false;
  }
  for (int k = -reach; k <= reach; ++k) {
    const int px = x + k * dx;
    const int py = y + k * dy;
    if (!std::isfinite(g.depth(px, py)) || !SameNormal(g.normal, x, y, px, py) ||
        (!g.id.empty() && g.id(px, py) != g.id(x, y))) {
      return false;
    }
  }
  return true;
}

}  // namespace stillray::doctor
