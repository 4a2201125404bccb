// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "core/second_moments.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "core/guides.h"
#include "core/pixels.h"

namespace stillray::second_moments_test {
namespace {

constexpr int kWidth = 64;
constexpr int kHeight = 48;

/// Flat grey diffuse light behind an albedo of 1/2.
Frame Grey(float light) {
  Frame frame;
  frame.width = kWidth;
  frame.height = kHeight;
  frame.guides.depth = FlatDepth(kWidth, kHeight);
  frame.guides.albedo = WhiteAlbedo(kWidth, kHeight);
  Signal signal;
  signal.radiance = Image3(kWidth, kHeight);
  for (int c = 0; c < 3; ++c) {
    frame.guides.albedo[c].Fill(0.5f);
    signal.radiance[c].Fill(light);
  }
  frame.signals.push_back(std::move(signal));
  frame.samples = Image1(kWidth, kHeight);
  frame.samples.Fill(16);
  return frame;
}

void SetLight(int x, int y, float light, Frame* frame) {
  for (int c = 0; c < 3; ++c) {
    frame->signals[0].radiance[c](x, y) = light;
  }
}

/// The variance of single samples that the moment of a pixel stands for.
double VarianceOfSample(const Frame& frame, int x, int y) {
  const double l = frame.signals[0].radiance[0](x, y) / 0.5;
  const double n = frame.samples(x, y);
  return (frame.signals[0].second_moment(x, y) - l * l) * n / (n - 1);
}

TEST(SecondMoments, OneBrightPixelByHand) {
  Frame frame = Grey(1);
  SetLight(20, 20, 1.5f, &frame);  // 3 in place of 2
  EstimateSecondMoments(&frame);
  // At the bright pixel all nine squares lie in its window: 1 + 4 + 16 + ... = 36. Each of the 25
  // results has the variance 36 / 16.
  const double v = 36.0 / (25.0 * 36.0 / 16.0);
  EXPECT_NEAR(frame.signals[0].second_moment(20, 20), 9 + v * 15 / 16, 1e-5);
  // Three pixels to the right only the squares 1, 4, 1 of the column beside it do.
  EXPECT_NEAR(frame.signals[0].second_moment(23, 20), 4 + v * 6 / 36 * 15 / 16, 1e-5);
  EXPECT_NEAR(frame.signals[0].second_moment(24, 20), 4, 1e-6);
}

TEST(SecondMoments, NoiseOfAnyCountsHasTheVarianceOfItsSamples) {
  // Samples of variance 1 after the division by albedo, counts of 2 to 64 that change block by
  // block, over a slope.
  Frame frame = Grey(0);
  std::mt19937 random(7);
  std::normal_distribution<float> normal;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const float n = std::exp2(static_cast<float>(1 + (x / 4 + y / 4) % 6));
      frame.samples(x, y) = n;
      const float mean = 10 + 0.5f * static_cast<float>(x) - 0.1f * static_cast<float>(y);
      SetLight(x, y, 0.5f * (mean + normal(random) / std::sqrt(n)), &frame);
    }
  }
  EstimateSecondMoments(&frame);
  double sum = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      sum += VarianceOfSample(frame, x, y);
    }
  }
  EXPECT_NEAR(sum / (kWidth * kHeight), 1, 0.1);
}

TEST(SecondMoments, SlopesHaveNone) {
  Frame frame = Grey(0);
  ForEachPixel(kWidth, kHeight, [&](int x, int y) {
    SetLight(x, y, 1 + 0.25f * static_cast<float>(x) + 0.5f * static_cast<float>(y), &frame);
  });
  EstimateSecondMoments(&frame);
  EXPECT_NEAR(VarianceOfSample(frame, 30, 30), 0, 1e-2);
  EXPECT_NEAR(VarianceOfSample(frame, 0, 0), 0, 1e-2);
}

TEST(SecondMoments, MissingPixelsAndSkyReachNoOther) {
  Frame frame = Grey(1);
  SetLight(20, 20, 1e9f, &frame);
  frame.samples(20, 20) = 0;
  SetLight(30, 20, NAN, &frame);
  SetLight(40, 20, 1e9f, &frame);
  frame.guides.depth(40, 20) = INFINITY;
  EstimateSecondMoments(&frame);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const bool absent = y == 20 && (x == 20 || x == 30 || x == 40);
      EXPECT_FLOAT_EQ(frame.signals[0].second_moment(x, y), absent ? 0.0f : 4.0f);
    }
  }
}

TEST(SecondMoments, ASingleSampleNeedsNone) {
  Frame frame = Grey(1);
  frame.samples.Fill(1);
  EstimateSecondMoments(&frame);
  EXPECT_TRUE(frame.signals[0].second_moment.empty());
  frame.samples = Image1();
  EstimateSecondMoments(&frame);
  EXPECT_TRUE(frame.signals[0].second_moment.empty());
}

TEST(SecondMoments, GivenOnesStay) {
  Frame frame = Grey(1);
  frame.signals[0].second_moment = Image1(kWidth, kHeight);
  frame.signals[0].second_moment.Fill(5);
  EstimateSecondMoments(&frame);
  EXPECT_EQ(frame.signals[0].second_moment(3, 3), 5);
}

TEST(SecondMoments, PicturesOfAFewPixelsHaveNoVariance) {
  Frame frame = Grey(1);
  frame.width = 2;
  frame.height = 1;
  frame.samples = Image1(2, 1);
  frame.samples.Fill(4);
  frame.guides.depth = FlatDepth(2, 1);
  frame.guides.albedo = WhiteAlbedo(2, 1);
  frame.signals[0].radiance = WhiteAlbedo(2, 1);
  EstimateSecondMoments(&frame);
  EXPECT_FLOAT_EQ(frame.signals[0].second_moment(1, 0), 1);
}

}  // namespace
}  // namespace stillray::second_moments_test
