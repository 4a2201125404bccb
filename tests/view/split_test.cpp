// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "view/split.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace stillray::view::split_test {
namespace {

using ::testing::ElementsAre;
using ::testing::FloatEq;

Rgb8Image Flat(int width, int height, uint8_t value) {
  Rgb8Image image{width, height, {}};
  image.pixels.assign(static_cast<size_t>(width) * height * 3, value);
  return image;
}

uint8_t At(const Rgb8Image& image, int x, int y) {
  return image.pixels[(static_cast<size_t>(y) * image.width + x) * 3];
}

TEST(Split, WithoutDividersPanesAreEven) {
  EXPECT_THAT(PaneEnds({}, 1), ElementsAre(1.0f));
  EXPECT_THAT(PaneEnds({}, 2), ElementsAre(0.5f, 1.0f));
  EXPECT_THAT(PaneEnds({}, 4), ElementsAre(0.25f, 0.5f, 0.75f, 1.0f));
}

TEST(Split, DividersKeepTheirOrderAndStayInside) {
  EXPECT_THAT(PaneEnds({0.8f, 0.2f}, 3), ElementsAre(FloatEq(0.8f), FloatEq(0.81f), 1.0f));
  EXPECT_THAT(PaneEnds({-5}, 2), ElementsAre(FloatEq(0.01f), 1.0f));
  EXPECT_THAT(PaneEnds({5, 5}, 3), ElementsAre(FloatEq(0.98f), FloatEq(0.99f), 1.0f));
}

TEST(Split, EveryPaneShowsItsOwnPicture) {
  const Rgb8Image image =
      ComposePanes({Flat(100, 3, 10), Flat(100, 3, 20), Flat(100, 3, 30)}, {0.2f, 0.6f});
  for (int y = 0; y < 3; ++y) {
    EXPECT_EQ(At(image, 0, y), 10);
    EXPECT_EQ(At(image, 19, y), 10);
    EXPECT_EQ(At(image, 20, y), 230);  // the line
    EXPECT_EQ(At(image, 21, y), 20);
    EXPECT_EQ(At(image, 59, y), 20);
    EXPECT_EQ(At(image, 61, y), 30);
    EXPECT_EQ(At(image, 99, y), 30);
  }
}

TEST(Split, OnePictureStaysWhatItIs) {
  EXPECT_EQ(ComposePanes({Flat(7, 5, 99)}, {0.5f}).pixels, Flat(7, 5, 99).pixels);
}

TEST(Split, TinyPicturesDoNotBreak) {
  const Rgb8Image image = ComposePanes({Flat(1, 1, 1), Flat(1, 1, 2), Flat(1, 1, 3)}, {});
  EXPECT_EQ(image.pixels.size(), 3u);
}

Rgb8Image Ramp() {
  return {2, 1, {0, 0, 0, 200, 100, 40}};
}

TEST(Split, SmallPicturesAreEnlargedAsTheWindowDoes) {
  const Rgb8Image smooth = EnlargedTo(4, 2, false, Ramp());
  ASSERT_EQ(smooth.pixels.size(), 4u * 2 * 3);
  EXPECT_EQ(smooth.pixels[0], 0);
  EXPECT_EQ(smooth.pixels[3], 50);
  EXPECT_EQ(smooth.pixels[6], 150);
  EXPECT_EQ(smooth.pixels[9], 200);
  EXPECT_EQ(smooth.pixels[10], 100);
  const Rgb8Image sharp = EnlargedTo(4, 2, true, Ramp());
  EXPECT_EQ(sharp.pixels[3], 0);
  EXPECT_EQ(sharp.pixels[6], 200);
}

TEST(Split, LargePicturesStayAsTheyAre) {
  const Rgb8Image same = EnlargedTo(2, 1, false, Ramp());
  EXPECT_EQ(same.width, 2);
  EXPECT_EQ(same.pixels, Ramp().pixels);
}

}  // namespace
}  // namespace stillray::view::split_test
