// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "io/mixed_motion.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "core/guides.h"

namespace stillray::io::mixed_motion_test {
namespace {

constexpr int kSize = 24;

/// A square that moves by (6, 2) before a background that moves by (-1, 0), with a border of pixels
/// that show half of each.
Image2 Square(bool mixed) {
  Image2 motion(kSize, kSize);
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x) {
      const int outside = std::max(std::max(8 - x, x - 15), std::max(8 - y, y - 15));
      const float part = outside <= 0 ? 1.0f : outside == 1 && mixed ? 0.5f : 0.0f;
      // Coverage varies along a real outline.
      const float covered = part == 0.5f ? 0.3f + 0.4f * static_cast<float>((x + y) % 3) / 2 : part;
      motion[0](x, y) = covered * 6 - (1 - covered);
      motion[1](x, y) = covered * 2;
    }
  }
  return motion;
}

bool IsUnknown(const Image2& motion, int x, int y) {
  return vec2(motion[0](x, y), motion[1](x, y)) == UnknownMotion(kSize, kSize);
}

TEST(ForgetMixedMotion, MeansAtAnOutlineAreUnknown) {
  Image2 motion = Square(true);
  const Image2 stored = motion;
  EXPECT_GT(ForgetMixedMotion(&motion), 24);
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x) {
      const bool border = std::max(std::max(8 - x, x - 15), std::max(8 - y, y - 15)) == 1;
      if (!border) {
        EXPECT_FALSE(IsUnknown(motion, x, y)) << x << " " << y;
        EXPECT_EQ(motion[0](x, y), stored[0](x, y));
      }
    }
  }
}

TEST(ForgetMixedMotion, ASharpOutlineStays) {
  Image2 motion = Square(false);
  EXPECT_EQ(ForgetMixedMotion(&motion), 0);
  EXPECT_EQ(motion[0](10, 10), 6);
}

TEST(ForgetMixedMotion, SmoothMotionStays) {
  Image2 motion(kSize, kSize);
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x) {  // zoom by 40 pixels at the corners
      motion[0](x, y) = 0.45f * static_cast<float>(x - kSize / 2);
      motion[1](x, y) = 0.45f * static_cast<float>(y - kSize / 2);
    }
  }
  EXPECT_EQ(ForgetMixedMotion(&motion), 0);
}

TEST(ForgetMixedMotion, InvalidValuesAndTinyPicturesStay) {
  Image2 motion(3, 3);
  motion[0](1, 1) = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(ForgetMixedMotion(&motion), 0);
  EXPECT_TRUE(std::isnan(motion[0](1, 1)));
  Image2 tiny(1, 2);
  EXPECT_EQ(ForgetMixedMotion(&tiny), 0);
}

}  // namespace
}  // namespace stillray::io::mixed_motion_test
