// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "pictures.h"
#include "stillray/quality.h"

namespace stillray::psnr_test {
namespace {

double Psnr(const Image3& test, const Image3& reference, bool display) {
  const Result<ImageMetrics> metrics = CompareImages(test, reference, display);
  EXPECT_TRUE(metrics.ok()) << metrics.status().message();
  return metrics.ok() ? metrics->psnr : -1;
}

TEST(Psnr, EqualPicturesAreInfinitelyGood) {
  const Image3 noise = NoisePicture(17, 9, 1);
  EXPECT_EQ(Psnr(noise, noise, false), std::numeric_limits<double>::infinity());
}

// 1 becomes 1/2 and 3 becomes 3/4: one channel of three differs by 1/4.
TEST(Psnr, RadianceIsCompressed) {
  const Image3 reference = ConstantPicture(5, 4, {1, 1, 1});
  const Image3 test = ConstantPicture(5, 4, {1, 3, 1});
  EXPECT_NEAR(Psnr(test, reference, false), -10 * std::log10(0.0625 / 3), 1e-9);
}

// The linear values of the sRGB bytes 51 and 102 are 0.0331048 and 0.1328683: a difference of
// 51/255 = 0.2 in the file.
TEST(Psnr, DisplayPicturesCountAsTheirFilesValues) {
  const Image3 reference = ConstantPicture(5, 4, {0.0331048f, 0.0331048f, 0.0331048f});
  const Image3 test = ConstantPicture(5, 4, {0.1328683f, 0.1328683f, 0.1328683f});
  EXPECT_NEAR(Psnr(test, reference, true), -10 * std::log10(0.04), 1e-4);
}

TEST(Psnr, BlackAndWhiteDisplayPicturesHaveZeroDecibels) {
  EXPECT_NEAR(Psnr(ConstantPicture(3, 3, {0, 0, 0}), ConstantPicture(3, 3, {1, 1, 1}), true), 0,
              1e-5);
}

TEST(Psnr, NegativeLightCountsAsNone) {
  const Image3 black = ConstantPicture(3, 3, {0, 0, 0});
  const Image3 negative = ConstantPicture(3, 3, {-1, -0.5f, -1e30f});
  EXPECT_EQ(Psnr(negative, black, false), std::numeric_limits<double>::infinity());
}

// One pixel of 12 differs, in one channel, by 1/2.
TEST(Psnr, IsTheMeanOverPixelsAndChannels) {
  const Image3 reference(4, 3);
  Image3 test = reference;
  test[2](3, 2) = 1;
  EXPECT_NEAR(Psnr(test, reference, false), -10 * std::log10(0.25 / 36), 1e-9);
}

}  // namespace
}  // namespace stillray::psnr_test
