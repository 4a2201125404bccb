// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "view/motion_arrows.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace stillray::view::motion_arrows_test {
namespace {

constexpr int kWidth = 64;
constexpr int kHeight = 48;

Rgb8Image Grey() {
  Rgb8Image picture;
  picture.width = kWidth;
  picture.height = kHeight;
  picture.pixels.assign(size_t{kWidth} * kHeight * 3, 100);
  return picture;
}

bool IsArrow(const Rgb8Image& picture, int x, int y) {
  const uint8_t* p = picture.pixels.data() + (static_cast<size_t>(y) * kWidth + x) * 3;
  return p[0] > 200 && p[1] > 200 && p[2] < 100;
}

int CountArrows(const Rgb8Image& picture, int x0, int x1) {
  int count = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = x0; x < x1; ++x) {
      count += IsArrow(picture, x, y) ? 1 : 0;
    }
  }
  return count;
}

TEST(MotionArrows, LengthGrowsWithSpeed) {
  EXPECT_FLOAT_EQ(ArrowLength(0), 0);
  EXPECT_NEAR(ArrowLength(0.1f), 3.4f, 0.05f);
  EXPECT_NEAR(ArrowLength(1), 12.7f, 0.05f);
  EXPECT_NEAR(ArrowLength(4), 20.2f, 0.05f);
}

TEST(MotionArrows, PointWhereThingsGo) {
  // A point that was 1 pixel to the left one frame ago moves to the right.
  Image2 motion(kWidth, kHeight);
  motion[0](24, 24) = -1;
  Rgb8Image picture = Grey();
  DrawMotionArrows(motion, &picture);
  EXPECT_TRUE(IsArrow(picture, 24, 24));
  EXPECT_TRUE(IsArrow(picture, 36, 24));
  EXPECT_EQ(CountArrows(picture, 0, 24), 0);
  EXPECT_GT(CountArrows(picture, 24, kWidth), 12);
}

TEST(MotionArrows, StillThingsAreDotsAndThePictureIsDarker) {
  const Image2 motion(kWidth, kHeight);
  Rgb8Image picture = Grey();
  DrawMotionArrows(motion, &picture);
  int dots = 0;
  for (size_t i = 0; i < picture.pixels.size(); i += 3) {
    dots += picture.pixels[i] != 50 ? 1 : 0;
  }
  EXPECT_EQ(dots, (kWidth / kArrowSpacing) * (kHeight / kArrowSpacing));
}

TEST(MotionArrows, WildMotionStaysInThePicture) {
  Image2 motion(kWidth, kHeight);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      motion[0](x, y) = x % 2 == 0 ? 1e30f : -1e30f;
      motion[1](x, y) = y % 3 == 0 ? NAN : 1e30f;
    }
  }
  Rgb8Image picture = Grey();
  DrawMotionArrows(motion, &picture);
  EXPECT_EQ(picture.pixels.size(), size_t{kWidth} * kHeight * 3);
}

}  // namespace
}  // namespace stillray::view::motion_arrows_test
