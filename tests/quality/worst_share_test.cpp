// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <functional>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "pictures.h"
#include "stillray/quality.h"

namespace stillray::worst_share_test {
namespace {

double WorstShare(const Image3& test, const Image3& reference, bool display = false) {
  const Result<ImageMetrics> metrics = CompareImages(test, reference, display);
  EXPECT_TRUE(metrics.ok()) << metrics.status().message();
  return metrics.ok() ? metrics->worst_share : -1;
}

TEST(WorstShare, EqualPicturesHaveNoError) {
  const Image3 noise = NoisePicture(17, 9, 1);
  EXPECT_EQ(WorstShare(noise, noise), 0);
}

TEST(WorstShare, EvenErrorHasOneHundredth) {
  const Image3 one = ConstantPicture(20, 10, {1, 1, 1});
  const Image3 three = ConstantPicture(20, 10, {3, 3, 3});
  EXPECT_NEAR(WorstShare(three, one), 0.01, 1e-12);
}

// 50 pixels: 1 % is rounded up to one of them.
TEST(WorstShare, IsAllOfTheErrorOfOnePixel) {
  const Image3 reference = ConstantPicture(10, 5, {1, 1, 1});
  Image3 test = reference;
  test[1](3, 3) = 7;
  EXPECT_EQ(WorstShare(test, reference), 1);
}

// 200 pixels, of which 2 count. On the curve three errors: 1/2 in two channels, 1/4 in one, and 1/2
// in one.
TEST(WorstShare, ComparesSquaresSummedOverChannels) {
  const Image3 reference = ConstantPicture(20, 10, {1, 1, 1});
  Image3 test = reference;
  test[0](1, 1) = 0;
  test[1](1, 1) = 0;
  test[2](8, 9) = 3;
  test[0](12, 4) = -1;  // counts as 0
  EXPECT_NEAR(WorstShare(test, reference), 0.75 / (0.75 + 0.0625), 1e-9);
}

TEST(WorstShare, BlackAndWhiteDisplayPictures) {
  const Image3 black = ConstantPicture(20, 10, {0, 0, 0});
  Image3 test = black;
  for (int x = 0; x < 4; ++x) {
    test[0](x, 0) = 1;
  }
  EXPECT_NEAR(WorstShare(test, black, true), 0.5, 1e-6);
}

// Of 201 pixels three count, of the 200 that are finite two.
TEST(WorstShare, PixelsThatAreNotFiniteAreLeftOut) {
  const Image3 reference = ConstantPicture(67, 3, {1, 1, 1});
  Image3 test = reference;
  for (int x = 0; x < 4; ++x) {
    test[1](x, 2) = 3;
  }
  EXPECT_NEAR(WorstShare(test, reference), 0.75, 1e-12);
  test[2](50, 1) = std::numeric_limits<float>::infinity();
  EXPECT_NEAR(WorstShare(test, reference), 0.5, 1e-12);
}

TEST(WorstShare, AgreesWithTheDefinitionOnNoise) {
  const Image3 reference = NoisePicture(61, 33, 1, 3.0f);
  const Image3 test = NoisePicture(61, 33, 2, 3.0f);
  std::vector<double> errors;
  double sum = 0;
  for (int y = 0; y < 33; ++y) {
    for (int x = 0; x < 61; ++x) {
      double error = 0;
      for (int c = 0; c < 3; ++c) {
        const double t = test[c](x, y);
        const double r = reference[c](x, y);
        error += (t / (1 + t) - r / (1 + r)) * (t / (1 + t) - r / (1 + r));
      }
      errors.push_back(error);
      sum += error;
    }
  }
  std::sort(errors.begin(), errors.end(), std::greater<>());
  double worst = 0;
  for (size_t i = 0; i < 21; ++i) {  // 2013 pixels
    worst += errors[i];
  }
  EXPECT_NEAR(WorstShare(test, reference), worst / sum, 1e-9);
}

}  // namespace
}  // namespace stillray::worst_share_test
