// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <limits>

#include <gtest/gtest.h>

#include "pictures.h"
#include "stillray/quality.h"

namespace stillray::region_brightness_test {
namespace {

ImageMetrics Compare(const Image3& test, const Image3& reference, bool display = false) {
  const Result<ImageMetrics> metrics = CompareImages(test, reference, display);
  EXPECT_TRUE(metrics.ok()) << metrics.status().message();
  return metrics.ok() ? *metrics : ImageMetrics();
}

/// Multiplies the pixels x0 <= x < x1, y0 <= y < y1.
void Scale(int x0, int x1, int y0, int y1, float factor, Image3* image) {
  for (int c = 0; c < 3; ++c) {
    for (int y = y0; y < y1; ++y) {
      for (int x = x0; x < x1; ++x) {
        (*image)[c](x, y) *= factor;
      }
    }
  }
}

TEST(RegionBrightness, EqualPicturesHaveOne) {
  const Image3 scene = ScenePicture(130, 70);
  EXPECT_EQ(Compare(scene, scene).brightness_lowest, 1);
  EXPECT_EQ(Compare(scene, scene).brightness_highest, 1);
}

// 160 x 128 pixels: regions of 20 x 16.
TEST(RegionBrightness, FindsTheRegionThatIsDimmedAndTheOneThatIsLit) {
  const Image3 reference = ScenePicture(160, 128);
  Image3 test = reference;
  Scale(40, 60, 16, 32, 0.5f, &test);
  Scale(140, 160, 112, 128, 1.75f, &test);
  const ImageMetrics metrics = Compare(test, reference);
  EXPECT_NEAR(metrics.brightness_lowest, 0.5, 1e-9);
  EXPECT_NEAR(metrics.brightness_highest, 1.75, 1e-6);
}

TEST(RegionBrightness, IsTheRatioOfTheRegionsMeans) {
  const Image3 reference = ConstantPicture(160, 128, {1, 1, 1});
  Image3 test = reference;
  Scale(50, 60, 16, 32, 0.5f, &test);  // half of a region
  EXPECT_NEAR(Compare(test, reference).brightness_lowest, 0.75, 1e-9);
  EXPECT_EQ(Compare(test, reference).brightness_highest, 1);
}

// 95 / 6 and 31 / 2 would be too few: five columns of 19 pixels, and one row.
TEST(RegionBrightness, RegionsHaveSixteenPixelsASideOrMore) {
  const Image3 reference = ConstantPicture(95, 31, {1, 1, 1});
  for (int begin = 0; begin < 95; begin += 19) {
    Image3 test = reference;
    Scale(begin, begin + 19, 0, 31, 0.0f, &test);
    EXPECT_EQ(Compare(test, reference).brightness_lowest, 0) << begin;
    EXPECT_EQ(Compare(test, reference).brightness_highest, 1) << begin;
  }
  Image3 test = reference;
  Scale(0, 95, 0, 15, 0.0f, &test);
  EXPECT_NEAR(Compare(test, reference).brightness_lowest, 16.0 / 31, 1e-9);
  EXPECT_NEAR(Compare(test, reference).brightness_highest, 16.0 / 31, 1e-9);
  const Image3 small = ConstantPicture(3, 2, {1, 1, 1});
  Image3 half = small;
  Scale(0, 3, 0, 1, 0.5f, &half);
  EXPECT_NEAR(Compare(half, small).brightness_lowest, 0.75, 1e-9);
  EXPECT_NEAR(Compare(half, small).brightness_highest, 0.75, 1e-9);
}

// Two regions. The dark one has 0.0075 of the mean first, then 0.0125.
TEST(RegionBrightness, RegionsWithoutLightDoNotCount) {
  Image3 reference = ConstantPicture(32, 16, {1, 1, 1});
  Scale(16, 32, 0, 16, 0.00375f, &reference);
  Image3 test = reference;
  Scale(16, 32, 0, 16, 9.0f, &test);
  EXPECT_EQ(Compare(test, reference).brightness_highest, 1);
  Scale(16, 32, 0, 16, 5.0f / 3, &reference);
  EXPECT_NEAR(Compare(test, reference).brightness_highest, 5.4, 1e-6);
}

TEST(RegionBrightness, IsOneWhereNothingCounts) {
  const Image3 black(32, 16);
  const Image3 white = ConstantPicture(32, 16, {1, 1, 1});
  EXPECT_EQ(Compare(white, black).brightness_lowest, 1);
  EXPECT_EQ(Compare(white, black).brightness_highest, 1);
}

TEST(RegionBrightness, DisplayPicturesAreLinear) {
  const Image3 reference = ConstantPicture(64, 64, {0.5f, 0.5f, 0.5f});
  Image3 test = reference;
  Scale(16, 32, 16, 32, 0.5f, &test);
  EXPECT_NEAR(Compare(test, reference, true).brightness_lowest, 0.5, 1e-9);
}

TEST(RegionBrightness, PixelsThatAreNotFiniteAreLeftOut) {
  const Image3 reference = ConstantPicture(64, 64, {1, 1, 1});
  Image3 test = reference;
  Scale(16, 32, 16, 32, 0.5f, &test);
  test[0](20, 20) = std::numeric_limits<float>::infinity();
  // A whole region that is not finite does not count.
  Scale(48, 64, 48, 64, std::numeric_limits<float>::quiet_NaN(), &test);
  const ImageMetrics metrics = Compare(test, reference);
  EXPECT_EQ(metrics.non_finite, 257);
  EXPECT_NEAR(metrics.brightness_lowest, 0.5, 1e-9);
  EXPECT_EQ(metrics.brightness_highest, 1);
}

}  // namespace
}  // namespace stillray::region_brightness_test
