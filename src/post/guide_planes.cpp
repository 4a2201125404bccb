// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "post/guide_planes.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "core/parallel.h"

namespace stillray::post {

Status CheckSize(const char* name, int width, int height, const Image3& colour) {
  if (width == colour.width() && height == colour.height()) {
    return Status::Ok();
  }
  return Status::InvalidArgument(fmt::format("{} has {} x {} pixels, the picture {} x {}", name,
                                             width, height, colour.width(), colour.height()));
}

float InverseDepth(float depth) {
  constexpr float kMost = std::numeric_limits<float>::max();
  return depth > 0.0f ? std::min(1.0f / depth, kMost) : 0.0f;
}

void FillBorder(Image1* plane) {
  const int border = plane->border();
  const int width = plane->width();
  const int height = plane->height();
  for (int y = 0; y < height; ++y) {
    float* row = plane->Row(y);
    std::fill(row - border, row, row[0]);
    std::fill(row + width, row + width + border, row[width - 1]);
  }
  for (int y = 1; y <= border; ++y) {
    std::copy_n(plane->Row(0) - border, width + 2 * border, plane->Row(-y) - border);
    std::copy_n(plane->Row(height - 1) - border, width + 2 * border,
                plane->Row(height - 1 + y) - border);
  }
}

Image3 FiniteLight(const Image3& colour, int border) {
  constexpr int kBand = 16;
  Image3 light(colour.width(), colour.height(), border);
  for (int c = 0; c < 3; ++c) {
    ParallelRows(colour.height(), kBand, [&](int y0, int y1) {
      for (int y = y0; y < y1; ++y) {
        const float* from = colour[c].Row(y);
        float* to = light[c].Row(y);
        for (int x = 0; x < colour.width(); ++x) {
          to[x] = std::isfinite(from[x]) ? from[x] : 0.0f;
        }
      }
    });
    FillBorder(&light[c]);
  }
  return light;
}

}  // namespace stillray::post
