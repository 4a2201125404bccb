// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "io/light_confidence.h"

#include <algorithm>
#include <cmath>

#include "core/pixels.h"

namespace stillray::io {
namespace {

/// Half the sides of the squares around a pixel.
constexpr int kVolumeReach = 3;
constexpr int kMixedReach = 2;
/// Fraction of the radiance from which on a pixel counts as volume.
constexpr float kWholePart = 0.25f;
/// 1 minus the length of normals at which guides begin to count as mixed, and count in full.
constexpr float kMixed = 0.05f;
constexpr float kWhollyMixed = 0.15f;
constexpr float kMoving = 0.25f;  ///< pixels
/// Loss of confidence with each doubling of the samples.
constexpr float kVolumePerDoubling = 0.325f;
constexpr float kMixedPerDoubling = 0.15f;
constexpr float kLeast = 0.35f;

/// Sums over the square around each pixel, clipped to the image; separable, rows first.
/// \param value_at  of a pixel, finite
template <typename ValueAt>
Image1 SquareSums(int width, int height, int reach, const ValueAt& value_at) {
  Image1 rows(width, height);
  ForEachPixel(width, height, [&](int x, int y) {
    float sum = 0;
    for (int u = std::max(x - reach, 0); u <= std::min(x + reach, width - 1); ++u) {
      sum += value_at(u, y);
    }
    rows(x, y) = sum;
  });
  Image1 sums(width, height);
  ForEachPixel(width, height, [&](int x, int y) {
    float sum = 0;
    for (int v = std::max(y - reach, 0); v <= std::min(y + reach, height - 1); ++v) {
      sum += rows(x, v);
    }
    sums(x, y) = sum;
  });
  return sums;
}

Image1 SumsOfLight(const Image3& light) {
  return SquareSums(light.width(), light.height(), kVolumeReach, [&](int x, int y) {
    const float value = light[0](x, y) + light[1](x, y) + light[2](x, y);
    return std::isfinite(value) ? std::max(value, 0.0f) : 0.0f;
  });
}

/// The length of a stored normal; 0 if invalid.
float LengthOf(const Image3& normal, int x, int y) {
  const float length = glm::length(VectorAt(normal, x, y));
  return std::isfinite(length) ? std::min(length, 1.0f) : 0.0f;
}

/// The confidence in a pixel that counts in full as volume.
float ConfidenceOf(const Image1& samples, int x, int y, float per_doubling) {
  const float n = samples.empty() ? 1.0f : samples(x, y);
  const float doublings = n > 1 ? std::log2(n) : 0.0f;
  return std::max(1 - per_doubling * doublings, kLeast);
}

}  // namespace

Image1 VolumeConfidence(const Image3& volume, const Image3& light, const Image1& samples) {
  const Image1 of_volume = SumsOfLight(volume);
  const Image1 of_all = SumsOfLight(light);
  Image1 confidence(volume.width(), volume.height());
  ForEachPixel(volume.width(), volume.height(), [&](int x, int y) {
    const float all = of_all(x, y);
    const float part = all > 0 ? std::min(of_volume(x, y) / (kWholePart * all), 1.0f) : 0.0f;
    confidence(x, y) = 1 - part * (1 - ConfidenceOf(samples, x, y, kVolumePerDoubling));
  });
  return confidence;
}

Image1 MixedLoss(const Image3& normal, const Image1& samples) {
  const int width = normal.width();
  const int height = normal.height();
  const Image1 surfaces = SquareSums(width, height, kMixedReach, [&](int x, int y) {
    return LengthOf(normal, x, y) > 0 ? 1.0f : 0.0f;
  });
  const Image1 lengths =
      SquareSums(width, height, kMixedReach, [&](int x, int y) { return LengthOf(normal, x, y); });
  Image1 loss(width, height);
  ForEachPixel(width, height, [&](int x, int y) {
    const float lacking = surfaces(x, y) > 0 ? 1 - lengths(x, y) / surfaces(x, y) : 0.0f;
    const float mixed = std::clamp((lacking - kMixed) / (kWhollyMixed - kMixed), 0.0f, 1.0f);
    loss(x, y) = mixed * (1 - ConfidenceOf(samples, x, y, kMixedPerDoubling));
  });
  return loss;
}

Image1 ConfidenceInMotion(const Image1& loss, const Image2& motion) {
  Image1 confidence(loss.width(), loss.height());
  ForEachPixel(loss.width(), loss.height(), [&](int x, int y) {
    const float way = std::hypot(motion[0](x, y), motion[1](x, y));
    const float moving = way < kMoving ? way / kMoving : 1.0f;
    confidence(x, y) = 1 - moving * loss(x, y);
  });
  return confidence;
}

}  // namespace stillray::io
