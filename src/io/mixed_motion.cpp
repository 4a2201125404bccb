// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "io/mixed_motion.h"

#include <atomic>
#include <cmath>
#include <cstdint>

#include "core/guides.h"
#include "core/pixels.h"

namespace stillray::io {

int64_t ForgetMixedMotion(Image2* motion) {
  constexpr float kSame = 0.5f;  // pixels
  constexpr int kFewest = 3;
  const int width = motion->width();
  const int height = motion->height();
  const Image2 stored = *motion;
  const vec2 unknown = UnknownMotion(width, height);
  std::atomic<int64_t> count = 0;
  ForEachPixel(width, height, [&](int x, int y) {
    if (x == 0 || y == 0 || x == width - 1 || y == height - 1) {
      return;
    }
    int same = -1;  // the pixel itself
    for (int v = y - 1; v <= y + 1; ++v) {
      for (int u = x - 1; u <= x + 1; ++u) {
        same += std::hypot(stored[0](u, v) - stored[0](x, y), stored[1](u, v) - stored[1](x, y)) <
                kSame;
      }
    }
    if (same < kFewest && std::isfinite(stored[0](x, y) + stored[1](x, y))) {
      (*motion)[0](x, y) = unknown.x;
      (*motion)[1](x, y) = unknown.y;
      ++count;
    }
  });
  return count;
}

}  // namespace stillray::io
