// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <limits>

#include <gtest/gtest.h>

#include "pictures.h"
#include "stillray/quality.h"

namespace stillray::rel_mse_test {
namespace {

// Channels by hand: (3 - 2)^2 / 4.01, 0, (0.5 - 0)^2 / 0.01.
TEST(RelMse, IsRelativeToTheReference) {
  const Image3 reference = ConstantPicture(6, 5, {2, 1, 0});
  const Image3 test = ConstantPicture(6, 5, {3, 1, 0.5f});
  const Result<ImageMetrics> metrics = CompareImages(test, reference, false);
  ASSERT_TRUE(metrics.ok());
  EXPECT_NEAR(metrics->rel_mse, (1 / 4.01 + 0.25 / 0.01) / 3, 1e-9);
}

TEST(RelMse, MapHoldsWhatTheMeanIsTakenOf) {
  const Image3 reference = ScenePicture(33, 18, 3.0f);
  const Image3 test = Blend(reference, NoisePicture(33, 18, 2), 0.5f);
  const Result<ImageMetrics> metrics = CompareImages(test, reference, false);
  const Result<Image1> map = MakeErrorMap(test, reference, false, ErrorMap::kRelativeSquaredError);
  ASSERT_TRUE(metrics.ok() && map.ok());
  double sum = 0;
  for (int y = 0; y < 18; ++y) {
    for (int x = 0; x < 33; ++x) {
      sum += (*map)(x, y);
    }
  }
  EXPECT_NEAR(sum / (33 * 18), metrics->rel_mse, 1e-6 * metrics->rel_mse);
}

// 1e30 squared is beyond float, not beyond double.
TEST(RelMse, FirefliesStayFinite) {
  const Image3 reference = ConstantPicture(2, 1, {1, 1, 1});
  Image3 test = reference;
  test[0](0, 0) = 1e30f;
  const Result<ImageMetrics> metrics = CompareImages(test, reference, false);
  const Result<Image1> map = MakeErrorMap(test, reference, false, ErrorMap::kRelativeSquaredError);
  ASSERT_TRUE(metrics.ok() && map.ok());
  EXPECT_NEAR(metrics->rel_mse / 1e60, 1 / 1.01 / 6, 1e-6);
  EXPECT_EQ((*map)(0, 0), std::numeric_limits<float>::max());
  EXPECT_EQ((*map)(1, 0), 0);
}

TEST(Brightness, IsTheRatioOfMeanLuminance) {
  const Image3 reference = ConstantPicture(4, 4, {1, 1, 1});
  const Image3 test = ConstantPicture(4, 4, {2, 0.5f, 1});
  const Result<ImageMetrics> metrics = CompareImages(test, reference, false);
  ASSERT_TRUE(metrics.ok());
  EXPECT_NEAR(metrics->brightness, 0.2126 * 2 + 0.7152 * 0.5 + 0.0722, 1e-9);
}

TEST(Brightness, OfBlackReferences) {
  const Image3 black = ConstantPicture(4, 4, {0, 0, 0});
  const Image3 grey = ConstantPicture(4, 4, {0.5f, 0.5f, 0.5f});
  const Result<ImageMetrics> both = CompareImages(black, black, false);
  const Result<ImageMetrics> one = CompareImages(grey, black, false);
  ASSERT_TRUE(both.ok() && one.ok());
  EXPECT_EQ(both->brightness, 1);
  EXPECT_EQ(one->brightness, std::numeric_limits<double>::infinity());
}

}  // namespace
}  // namespace stillray::rel_mse_test
