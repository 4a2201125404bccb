// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Pictures for the tests of the measures.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>

#include "core/random.h"
#include "stillray/image.h"

namespace stillray {

inline Image3 ConstantPicture(int width, int height, std::array<float, 3> rgb) {
  Image3 image(width, height);
  for (int c = 0; c < 3; ++c) {
    image[c].Fill(rgb[static_cast<size_t>(c)]);
  }
  return image;
}

/// Independent uniform values in 0..scale.
inline Image3 NoisePicture(int width, int height, uint32_t seed, float scale = 1.0f) {
  Image3 image(width, height);
  uint32_t counter = 0;
  for (int c = 0; c < 3; ++c) {
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        image[c](x, y) = scale * UniformFloat(HashCombine(seed, counter++));
      }
    }
  }
  return image;
}

/// Smooth colours with one hard edge: gradients, and a brighter square in the middle.
inline Image3 ScenePicture(int width, int height, float scale = 1.0f) {
  Image3 image(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const float u = (static_cast<float>(x) + 0.5f) / static_cast<float>(width);
      const float v = (static_cast<float>(y) + 0.5f) / static_cast<float>(height);
      const bool square = std::abs(u - 0.5f) < 0.2f && std::abs(v - 0.5f) < 0.2f;
      image[0](x, y) = scale * (square ? 0.9f : 0.1f + 0.6f * u);
      image[1](x, y) = scale * (square ? 0.7f : 0.2f + 0.5f * v);
      image[2](x, y) = scale * (square ? 0.2f : 0.5f * (1 - u) * (1 - v));
    }
  }
  return image;
}

/// a + amount * b.
inline Image3 Blend(const Image3& a, const Image3& b, float amount) {
  Image3 image(a.width(), a.height());
  for (int c = 0; c < 3; ++c) {
    for (int y = 0; y < a.height(); ++y) {
      for (int x = 0; x < a.width(); ++x) {
        image[c](x, y) = a[c](x, y) + amount * b[c](x, y);
      }
    }
  }
  return image;
}

}  // namespace stillray
