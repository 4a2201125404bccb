// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Helpers of the tests of single stages: pictures of every size and comparison with a tolerance.
#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <string>

#include <gtest/gtest.h>

#include "core/random.h"
#include "every_target.h"
#include "stillray/image.h"

namespace stillray::test {

struct PictureSize {
  int width;
  int height;
};

/// Narrower than a SIMD vector, as wide as some, and several of them with a rest.
inline constexpr PictureSize kPictureSizes[] = {{1, 1}, {2, 1},  {1, 9},  {5, 4},
                                                {8, 3}, {17, 5}, {33, 7}, {67, 21}};

/// Runs a comparison of the vector version with the reference, for each size on each instruction
/// set of this machine.
inline void ForSizesAndTargets(const std::function<void(int width, int height)>& compare) {
  for (const PictureSize& size : kPictureSizes) {
    SCOPED_TRACE(std::to_string(size.width) + "x" + std::to_string(size.height));
    OnEveryTarget([&] { compare(size.width, size.height); });
  }
}

/// In [0, 1).
inline float RandomAt(int x, int y, uint32_t seed) {
  return UniformFloat(
      HashCombine(HashCombine(static_cast<uint32_t>(x), static_cast<uint32_t>(y)), seed));
}

/// A picture by formula.
inline Image1 MakePlane(int width, int height, const std::function<float(int x, int y)>& value,
                        int border = 0) {
  Image1 plane(width, height, border);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      plane(x, y) = value(x, y);
    }
  }
  return plane;
}

template <typename Image = Image3>
Image MakeImage(int width, int height, const std::function<float(int x, int y, int c)>& value,
                int border = 0) {
  Image image(width, height, border);
  for (int c = 0; c < 3; ++c) {
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        image[c](x, y) = value(x, y, c);
      }
    }
  }
  return image;
}

/// Values in [0, most).
inline Image1 RandomPlane(int width, int height, uint32_t seed, float most = 1) {
  return MakePlane(width, height, [&](int x, int y) { return most * RandomAt(x, y, seed); });
}
template <typename Image = Image3>
Image RandomImage(int width, int height, uint32_t seed, float most = 1) {
  return MakeImage<Image>(width, height, [&](int x, int y, int c) {
    return most * RandomAt(x, y, seed + static_cast<uint32_t>(c));
  });
}

/// Expects |got - expected| <= absolute + relative |expected| for every pixel.
inline void ExpectNear(const Image1& got, const Image1& expected, double relative,
                       double absolute = 0) {
  ASSERT_EQ(got.width(), expected.width());
  ASSERT_EQ(got.height(), expected.height());
  for (int y = 0; y < expected.height(); ++y) {
    for (int x = 0; x < expected.width(); ++x) {
      const double e = static_cast<double>(expected(x, y));
      ASSERT_NEAR(static_cast<double>(got(x, y)), e, absolute + relative * std::abs(e))
          << "at " << x << ", " << y;
    }
  }
}

template <int N, typename Basis>
void ExpectNear(const Planes<float, N, Basis>& got, const Planes<float, N, Basis>& expected,
                double relative, double absolute = 0) {
  for (int c = 0; c < N; ++c) {
    SCOPED_TRACE("channel " + std::to_string(c));
    ExpectNear(got[c], expected[c], relative, absolute);
  }
}

template <typename T>
void ExpectEqual(const Plane<T>& got, const Plane<T>& expected) {
  for (int y = 0; y < expected.height(); ++y) {
    for (int x = 0; x < expected.width(); ++x) {
      ASSERT_EQ(got(x, y), expected(x, y)) << "at " << x << ", " << y;
    }
  }
}

}  // namespace stillray::test
