// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "core/pixels.h"

#include <cstdint>
#include <limits>
#include <utility>

#include <gtest/gtest.h>

namespace stillray::pixels_test {
namespace {

bool IsNotZero(float v) {
  return v != 0;
}

/// Every pixel of odd and tiny sizes counts, and nothing beyond the picture.
TEST(AnyPixel, FindsAValueAnywhereInThePicture) {
  for (const auto& [width, height] : {std::pair{1, 1}, {1, 5}, {17, 1}, {35, 4}}) {
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        Image1 plane(width, height, 2);
        plane(x, y) = -1;
        EXPECT_TRUE(AnyPixel(plane, IsNotZero)) << x << " " << y;
      }
    }
    Image1 plane(width, height, 2);
    plane(-1, 0) = plane(width, height - 1) = plane(0, -1) = plane(0, height) = 1;
    EXPECT_FALSE(AnyPixel(plane, IsNotZero)) << width << "x" << height;
  }
}

TEST(AnyPixel, LooksAtAllPlanesOfAnImage) {
  for (int c = 0; c < 3; ++c) {
    Image3 image(5, 3);
    EXPECT_FALSE(AnyPixel(image, IsNotZero));
    image[c](4, 2) = 1;
    EXPECT_TRUE(AnyPixel(image, IsNotZero)) << c;
  }
}

TEST(AnyPixel, ComparesNanAsTheConditionDoes) {
  Image1 plane(3, 2);
  plane(1, 1) = std::numeric_limits<float>::quiet_NaN();
  EXPECT_TRUE(AnyPixel(plane, IsNotZero));
  EXPECT_FALSE(AnyPixel(plane, [](float v) { return v > 0; }));
}

TEST(AnyPixel, FindsNothingInEmptyPlanes) {
  const auto always = [](uint8_t) { return true; };
  EXPECT_FALSE(AnyPixel(Plane<uint8_t>(), always));
  EXPECT_FALSE(AnyPixel(Plane<uint8_t>(0, 4), always));
  EXPECT_FALSE(AnyPixel(Image2(), IsNotZero));
}

}  // namespace
}  // namespace stillray::pixels_test
