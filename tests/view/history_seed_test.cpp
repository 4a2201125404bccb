// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "view/history_seed.h"

#include <algorithm>

#include <gtest/gtest.h>

namespace stillray::view::history_seed_test {
namespace {

Frame Guides(int width, int height) {
  Frame frame;
  frame.width = width;
  frame.height = height;
  frame.guides.depth = Image1(width, height);
  frame.guides.motion = Image2(width, height);
  frame.guides.motion[0](0, 0) = 7;
  frame.emission = Image3(width, height);
  frame.emission[1](0, 0) = 2;
  return frame;
}

TEST(HistorySeed, LightIsThePictureWithoutWhatIsNotFiltered) {
  Image3 picture(4, 2);
  for (int c = 0; c < 3; ++c) {
    for (int x = 0; x < 4; ++x) {
      picture[c](x, 0) = picture[c](x, 1) = static_cast<float>(3 + x);
    }
  }
  const Frame seed = SeedFrame(Guides(4, 2), picture, 8, false);
  ASSERT_EQ(seed.signals.size(), 1u);
  EXPECT_EQ(seed.signals[0].radiance[0](0, 0), 3);
  EXPECT_EQ(seed.signals[0].radiance[1](0, 0), 1) << "emission is added after the filter";
  EXPECT_EQ(seed.signals[0].radiance[2](3, 1), 6);
  EXPECT_EQ(seed.samples(2, 1), 8);
  EXPECT_EQ(seed.guides.motion[0](0, 0), 0) << "a picture does not move against itself";
}

TEST(HistorySeed, PicturesOfAnotherSizeAreResampled) {
  Image3 picture(8, 4);
  for (int c = 0; c < 3; ++c) {
    for (int y = 0; y < 4; ++y) {
      for (int x = 0; x < 8; ++x) {
        picture[c](x, y) = static_cast<float>(x);
      }
    }
  }
  const Frame half = SeedFrame(Guides(4, 2), picture, 1, false);
  EXPECT_FLOAT_EQ(half.signals[0].radiance[0](0, 0), 0.5f);
  EXPECT_FLOAT_EQ(half.signals[0].radiance[0](3, 1), 6.5f);
  const Frame twice = SeedFrame(Guides(16, 8), picture, 1, false);
  EXPECT_FLOAT_EQ(twice.signals[0].radiance[0](0, 0), 0);
  EXPECT_FLOAT_EQ(twice.signals[0].radiance[0](5, 3), 2.25f);
  EXPECT_FLOAT_EQ(twice.signals[0].radiance[0](15, 7), 7);
}

// A filter keeps guides for the holes of later frames only from a frame that has a hole itself.
TEST(HistorySeed, HasAHoleWhereGuidesAreToBeKept) {
  const Image3 picture(4, 2);
  Frame guides = Guides(4, 2);
  for (int y = 0; y < 2; ++y) {
    std::fill_n(guides.guides.depth.Row(y), 4, 1.0f);
  }
  const Frame seed = SeedFrame(guides, picture, 8, true);
  for (int y = 0; y < 2; ++y) {
    for (int x = 0; x < 4; ++x) {
      const bool hole = x == 0 && y == 0;
      EXPECT_EQ(seed.samples(x, y), hole ? 0.0f : 8.0f);
      EXPECT_EQ(seed.guides.depth(x, y) == 0.0f, hole);
    }
  }
}

}  // namespace
}  // namespace stillray::view::history_seed_test
