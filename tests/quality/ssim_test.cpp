// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include <gtest/gtest.h>

#include "pictures.h"
#include "stillray/quality.h"

namespace stillray::ssim_test {
namespace {

double Ssim(const Image3& test, const Image3& reference, bool display) {
  const Result<ImageMetrics> metrics = CompareImages(test, reference, display);
  EXPECT_TRUE(metrics.ok()) << metrics.status().message();
  return metrics.ok() ? metrics->ssim : -2;
}

double Luma(const Image3& image, int x, int y) {
  constexpr double kWeights[3] = {0.2126, 0.7152, 0.0722};
  double sum = 0;
  for (int c = 0; c < 3; ++c) {
    const double value = image[c](x, y);
    sum += kWeights[c] * value / (1 + value);
  }
  return sum;
}

/// Equation 13 at one pixel, in two passes over a two-dimensional window: means first, then
/// variances about them.
double SlowSsim(const Image3& test, const Image3& reference, int px, int py) {
  struct Sample {
    double weight, t, r;
  };
  std::vector<Sample> samples;
  double total = 0, mean_t = 0, mean_r = 0;
  for (int y = std::max(0, py - 5); y <= std::min(test.height() - 1, py + 5); ++y) {
    for (int x = std::max(0, px - 5); x <= std::min(test.width() - 1, px + 5); ++x) {
      const double d2 = (x - px) * (x - px) + (y - py) * (y - py);
      samples.push_back({std::exp(-d2 / (2 * 1.5 * 1.5)), Luma(test, x, y), Luma(reference, x, y)});
      total += samples.back().weight;
      mean_t += samples.back().weight * samples.back().t;
      mean_r += samples.back().weight * samples.back().r;
    }
  }
  mean_t /= total;
  mean_r /= total;
  double var_t = 0, var_r = 0, covariance = 0;
  for (const Sample& s : samples) {
    var_t += s.weight / total * (s.t - mean_t) * (s.t - mean_t);
    var_r += s.weight / total * (s.r - mean_r) * (s.r - mean_r);
    covariance += s.weight / total * (s.t - mean_t) * (s.r - mean_r);
  }
  constexpr double kC1 = 1e-4, kC2 = 9e-4;
  return (2 * mean_t * mean_r + kC1) * (2 * covariance + kC2) /
         ((mean_t * mean_t + mean_r * mean_r + kC1) * (var_t + var_r + kC2));
}

TEST(Ssim, EqualPicturesHaveOne) {
  const Image3 noise = NoisePicture(29, 31, 1);
  EXPECT_EQ(Ssim(noise, noise, false), 1);
  EXPECT_EQ(Ssim(noise, noise, true), 1);
}

// Constant pictures vary nowhere: SSIM is its luminance term, of 1/2 and 3/4.
TEST(Ssim, OfConstantPictures) {
  const Image3 a = ConstantPicture(20, 20, {1, 1, 1});
  const Image3 b = ConstantPicture(20, 20, {3, 3, 3});
  EXPECT_NEAR(Ssim(a, b, false), (2 * 0.5 * 0.75 + 1e-4) / (0.25 + 0.5625 + 1e-4), 1e-7);
}

TEST(Ssim, OfBlackAndWhiteDisplayPictures) {
  const Image3 black = ConstantPicture(20, 20, {0, 0, 0});
  const Image3 white = ConstantPicture(20, 20, {1, 1, 1});
  EXPECT_NEAR(Ssim(black, white, true), 1e-4 / (1 + 1e-4), 1e-6);
}

TEST(Ssim, IsSymmetric) {
  const Image3 a = ScenePicture(30, 20);
  const Image3 b = NoisePicture(30, 20, 4);
  EXPECT_NEAR(Ssim(a, b, false), Ssim(b, a, false), 1e-12);
}

// A picture and its negative: the covariance is minus the variance.
TEST(Ssim, OfOppositesIsNegative) {
  Image3 stripes(32, 32);
  Image3 opposite(32, 32);
  for (int c = 0; c < 3; ++c) {
    for (int y = 0; y < 32; ++y) {
      for (int x = 0; x < 32; ++x) {
        stripes[c](x, y) = (x / 2) % 2 == 0 ? 1.0f : 0.0f;
        opposite[c](x, y) = 1.0f - stripes[c](x, y);
      }
    }
  }
  EXPECT_LT(Ssim(stripes, opposite, true), -0.9);
}

TEST(Ssim, MatchesTheEquationAtEveryPixel) {
  const Image3 reference = ScenePicture(41, 70, 2.0f);
  const Image3 test = Blend(reference, NoisePicture(41, 70, 6), 0.4f);
  const Result<Image1> map = MakeErrorMap(test, reference, false, ErrorMap::kSsim);
  ASSERT_TRUE(map.ok());
  double sum = 0;
  for (int y = 0; y < 70; ++y) {
    for (int x = 0; x < 41; ++x) {
      const double expected = SlowSsim(test, reference, x, y);
      ASSERT_NEAR(1.0 - (*map)(x, y), expected, 1e-6) << "pixel " << x << ", " << y;
      sum += expected;
    }
  }
  EXPECT_NEAR(Ssim(test, reference, false), sum / (41 * 70), 1e-7);
}

// Smaller than the window.
TEST(Ssim, OfTinyPictures) {
  const Image3 reference = NoisePicture(3, 2, 8);
  const Image3 test = NoisePicture(3, 2, 9);
  const Result<Image1> map = MakeErrorMap(test, reference, false, ErrorMap::kSsim);
  ASSERT_TRUE(map.ok());
  for (int y = 0; y < 2; ++y) {
    for (int x = 0; x < 3; ++x) {
      EXPECT_NEAR(1.0 - (*map)(x, y), SlowSsim(test, reference, x, y), 1e-6);
    }
  }
}

}  // namespace
}  // namespace stillray::ssim_test
