// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/parallel.h"
#include "stillray/denoise.hpp"

namespace stillray {
namespace {

/// Motion at a position between pixels: bilinear, or that of the nearest pixel where the motions of
/// the four neighbours differ too much for a single surface.
struct MotionAt {
  const Image2& motion;

  float Component(int c, float x, float y) const {
    const int x0 = std::clamp(static_cast<int>(std::floor(x)), 0, motion.width() - 1);
    const int y0 = std::clamp(static_cast<int>(std::floor(y)), 0, motion.height() - 1);
    const int x1 = std::min(x0 + 1, motion.width() - 1);
    const int y1 = std::min(y0 + 1, motion.height() - 1);
    const float u = std::clamp(x - static_cast<float>(x0), 0.0f, 1.0f);
    const float v = std::clamp(y - static_cast<float>(y0), 0.0f, 1.0f);
    const Image1& m = motion[c];
    const float corner[4] = {m(x0, y0), m(x1, y0), m(x0, y1), m(x1, y1)};
    const auto [low, high] = std::minmax_element(corner, corner + 4);
    if (*high - *low > 1.0f) {
      return m(u < 0.5f ? x0 : x1, v < 0.5f ? y0 : y1);
    }
    return (1 - v) * ((1 - u) * corner[0] + u * corner[1]) +
           v * ((1 - u) * corner[2] + u * corner[3]);
  }
};

/// For every pixel p, the pixel q of the next frame whose motion leads to a neighbour of p, the
/// nearest surface of several; -1 if there is none.
Plane<int32_t> FindStarts(const Image2& next_motion, const Image1& next_depth) {
  const int width = next_motion.width();
  const int height = next_motion.height();
  Plane<int32_t> start(width, height);
  start.Fill(-1);
  Image1 nearest(width, height);
  nearest.Fill(std::numeric_limits<float>::infinity());
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const float px = std::floor(static_cast<float>(x) + next_motion[0](x, y));
      const float py = std::floor(static_cast<float>(y) + next_motion[1](x, y));
      // Also false for NaN.
      if (!(px > -2.0f && py > -2.0f && px < static_cast<float>(width) &&
            py < static_cast<float>(height))) {
        continue;
      }
      for (int i = 0; i < 4; ++i) {
        const int tx = static_cast<int>(px) + (i & 1);
        const int ty = static_cast<int>(py) + (i >> 1);
        const bool inside = tx >= 0 && ty >= 0 && tx < width && ty < height;
        if (inside && (start(tx, ty) < 0 || next_depth(x, y) < nearest(tx, ty))) {
          nearest(tx, ty) = next_depth(x, y);
          start(tx, ty) = y * width + x;
        }
      }
    }
  }
  return start;
}

}  // namespace

Image2 ReverseMotion(const Image2& next_motion, const Image1& next_depth) {
  constexpr int kIterations = 8;
  constexpr float kResidual = 0.25f;  // pixels
  const int width = next_motion.width();
  const int height = next_motion.height();
  const MotionAt at = {next_motion};
  const Plane<int32_t> starts = FindStarts(next_motion, next_depth);
  Image2 result(width, height);
  ParallelRows(height, 16, [&](int y_begin, int y_end) {
    for (int y = y_begin; y < y_end; ++y) {
      for (int x = 0; x < width; ++x) {
        const float px = static_cast<float>(x);
        const float py = static_cast<float>(y);
        const int32_t start = starts(x, y);
        float qx = start < 0 ? px : static_cast<float>(start % width);
        float qy = start < 0 ? py : static_cast<float>(start / width);
        float residual = 0;
        // A fixed point of q = p - motion(q): converges where motion changes by less than a pixel
        // per pixel, as on any continuous surface.
        for (int i = 0; i < kIterations; ++i) {
          const float mx = at.Component(0, qx, qy);
          const float my = at.Component(1, qx, qy);
          residual = std::max(std::abs(qx + mx - px), std::abs(qy + my - py));
          if (!(residual > 0)) {
            break;
          }
          qx = px - mx;
          qy = py - my;
        }
        const bool inside = qx > -1.0f && qy > -1.0f && qx < static_cast<float>(width) &&
                            qy < static_cast<float>(height);
        const bool found = inside && start >= 0 && residual <= kResidual;
        result[0](x, y) = found ? qx - px : 2.0f * static_cast<float>(width);
        result[1](x, y) = found ? qy - py : 2.0f * static_cast<float>(height);
      }
    }
  });
  return result;
}

}  // namespace stillray
