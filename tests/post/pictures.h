// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Pictures for the tests of the effects.
#pragma once

#include <cstring>
#include <random>

#include <tbb/global_control.h>

#include "stillray/image.h"

namespace stillray::post {

inline Image1 Flat(int width, int height, float value) {
  Image1 plane(width, height);
  plane.Fill(value);
  return plane;
}

inline Image3 FlatColour(int width, int height, float red, float green, float blue) {
  Image3 colour(width, height);
  const float values[] = {red, green, blue};
  for (int c = 0; c < 3; ++c) {
    colour[c].Fill(values[c]);
  }
  return colour;
}

inline Image1 Noise(int width, int height, float low, float high, unsigned seed) {
  std::mt19937 random(seed);
  Image1 plane(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      plane(x, y) = low + (high - low) * static_cast<float>(random() % 65536) / 65535.0f;
    }
  }
  return plane;
}

inline Image3 NoiseColour(int width, int height, unsigned seed) {
  Image3 colour(width, height);
  for (int c = 0; c < 3; ++c) {
    colour[c] = Noise(width, height, 0.0f, 2.0f, seed + static_cast<unsigned>(c));
  }
  return colour;
}

inline double SumOf(const Image1& plane) {
  double sum = 0;
  for (int y = 0; y < plane.height(); ++y) {
    for (int x = 0; x < plane.width(); ++x) {
      sum += static_cast<double>(plane(x, y));
    }
  }
  return sum;
}

inline bool SameBits(const Image3& a, const Image3& b) {
  for (int c = 0; c < 3; ++c) {
    for (int y = 0; y < a.height(); ++y) {
      if (std::memcmp(a[c].Row(y), b[c].Row(y), sizeof(float) * static_cast<size_t>(a.width())) !=
          0) {
        return false;
      }
    }
  }
  return true;
}

/// Limits the threads of the pool while it exists.
class Threads {
 public:
  explicit Threads(size_t count) : limit_(tbb::global_control::max_allowed_parallelism, count) {}

 private:
  tbb::global_control limit_;
};

}  // namespace stillray::post
