// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "io/volume_confidence.h"

#include <algorithm>
#include <cmath>

#include "core/pixels.h"

namespace stillray::io {
namespace {

constexpr int kReach = 3;
/// Part of the light from which on a pixel counts as one of the volume.
constexpr float kWholePart = 0.25f;
constexpr float kPerDoubling = 0.325f;
constexpr float kLeast = 0.35f;

/// Sums over the square around each pixel, as far as it is in the picture; first along rows.
Image1 SquareSums(const Image3& light) {
  const int width = light.width();
  const int height = light.height();
  Image1 rows(width, height);
  ForEachPixel(width, height, [&](int x, int y) {
    float sum = 0;
    for (int u = std::max(x - kReach, 0); u <= std::min(x + kReach, width - 1); ++u) {
      const float value = light[0](u, y) + light[1](u, y) + light[2](u, y);
      sum += std::isfinite(value) ? std::max(value, 0.0f) : 0.0f;
    }
    rows(x, y) = sum;
  });
  Image1 sums(width, height);
  ForEachPixel(width, height, [&](int x, int y) {
    float sum = 0;
    for (int v = std::max(y - kReach, 0); v <= std::min(y + kReach, height - 1); ++v) {
      sum += rows(x, v);
    }
    sums(x, y) = sum;
  });
  return sums;
}

float ConfidenceOf(float samples) {
  const float doublings = samples > 1 ? std::log2(samples) : 0.0f;
  return std::max(1 - kPerDoubling * doublings, kLeast);
}

}  // namespace

Image1 VolumeConfidence(const Image3& volume, const Image3& light, const Image1& samples) {
  const Image1 of_volume = SquareSums(volume);
  const Image1 of_all = SquareSums(light);
  Image1 confidence(volume.width(), volume.height());
  ForEachPixel(volume.width(), volume.height(), [&](int x, int y) {
    const float all = of_all(x, y);
    const float part = all > 0 ? std::min(of_volume(x, y) / (kWholePart * all), 1.0f) : 0.0f;
    const float full = samples.empty() ? 1.0f : ConfidenceOf(samples(x, y));
    confidence(x, y) = 1 - part * (1 - full);
  });
  return confidence;
}

}  // namespace stillray::io
