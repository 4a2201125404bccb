// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "denoise/stages/sum_albedo.h"

namespace stillray::reference {
namespace {

/// Marks the pixels for which IsBesideImage is true.
void MarkImages(const Image1& images, Image1* beside) {
  const int width = images.width();
  const int height = images.height();
  *beside = Image1(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      float nearest = images(x, y);
      float farthest = nearest;
      const int y0 = std::max(y / kAlbedoBlock - 1, 0) * kAlbedoBlock;
      const int x0 = std::max(x / kAlbedoBlock - 1, 0) * kAlbedoBlock;
      for (int v = y0; v < std::min((y / kAlbedoBlock + 2) * kAlbedoBlock, height); ++v) {
        for (int u = x0; u < std::min((x / kAlbedoBlock + 2) * kAlbedoBlock, width); ++u) {
          nearest = std::min(nearest, images(u, v));
          farthest = std::max(farthest, images(u, v));
        }
      }
      (*beside)(x, y) = IsBesideImage(images(x, y), nearest, farthest) ? 1.0f : 0.0f;
    }
  }
}

}  // namespace

void SumAlbedo(std::span<const Image3* const> albedos, const Image1* images, SummedAlbedo* out) {
  if (images != nullptr) {
    MarkImages(*images, &out->beside_image);
  } else {
    out->beside_image = Image1();
  }
  const int width = out->sum.width();
  const int height = out->sum.height();
  for (int c = 0; c < 3; ++c) {
    Image1& sum = out->sum[c];
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        sum(x, y) = 0;
        for (const Image3* albedo : albedos) {
          const float value = (*albedo)[c](x, y);
          sum(x, y) += std::isfinite(value) ? std::max(value, 0.0f) : 0.0f;
        }
      }
    }
    for (int by = 0; by < out->low.height(); ++by) {
      for (int bx = 0; bx < out->low.width(); ++bx) {
        float low = sum(bx * kAlbedoBlock, by * kAlbedoBlock);
        float high = low;
        for (int y = std::max(by - 1, 0) * kAlbedoBlock;
             y < std::min((by + 2) * kAlbedoBlock, height); ++y) {
          for (int x = std::max(bx - 1, 0) * kAlbedoBlock;
               x < std::min((bx + 2) * kAlbedoBlock, width); ++x) {
            low = std::min(low, sum(x, y));
            high = std::max(high, sum(x, y));
          }
        }
        out->low[c](bx, by) = low;
        out->high[c](bx, by) = high;
      }
    }
  }
}

}  // namespace stillray::reference
