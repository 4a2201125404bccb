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

/// 3 in place of 2, behind the albedo, of 16 samples.
Frame OneBrightPixel() {
  Frame frame = Grey(1);
  SetLight(20, 20, 1.5f, &frame);
  return frame;
}

TEST(SecondMoments, OneBrightPixelByHand) {
  Frame frame = OneBrightPixel();
  EstimateSecondMoments(&frame);
  // The squares of the nine blocks around it sum to 1 + 4 + 16 + ... = 36, each of variance 36
  // / 16.
  const double blocks = 36.0 / 9 / (36.0 / 16);
  // A quarter (4 of 16 samples) of what it estimates by itself: it differs by 1 from the mean of
  // eight, which has the variance (1 + 1 / 8) / 16.
  const double own = 0.25 / (1.125 / 16);
  EXPECT_NEAR(VarianceOfSample(frame, 20, 20), std::max(blocks, own), 1e-4);
  // Two pixels to the right the squares 1, 4, 1 of the blocks beside it remain. These pixels have
  // no bright neighbour of their own.
  EXPECT_NEAR(VarianceOfSample(frame, 22, 20), 6.0 / 9 / (36.0 / 16), 1e-4);
  EXPECT_NEAR(frame.signals[0].second_moment(23, 20), 4, 1e-6);
}

TEST(SecondMoments, PixelsOfFewSamplesCountForAllOfTheirOwnDifference) {
  Frame frame = OneBrightPixel();
  frame.samples.Fill(2);
  EstimateSecondMoments(&frame);
  EXPECT_NEAR(VarianceOfSample(frame, 20, 20), 1 / (1.125 / 2), 1e-4);
}

/// A step of the light from column 30 on, twice as bright.
Frame Step() {
  Frame frame = Grey(0);
  ForEachPixel(kWidth, kHeight, [&](int x, int y) { SetLight(x, y, x < 30 ? 1 : 2, &frame); });
  return frame;
}

double LargestVariance(const Frame& frame) {
  double most = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      most = std::max(most, VarianceOfSample(frame, x, y));
    }
  }
  return most;
}

TEST(SecondMoments, EdgesOfSurfacesAreNoNoise) {
  Frame lit = Step();  // on one surface
  SetLight(40, 20, 5, &lit);
  EstimateSecondMoments(&lit);
  ASSERT_GT(LargestVariance(lit), 1);

  Frame depth = Step();
  ForEachPixel(kWidth, kHeight,
               [&](int x, int y) { depth.guides.depth(x, y) = x < 30 ? 1.0f : 2.0f; });
  EstimateSecondMoments(&depth);
  EXPECT_LT(LargestVariance(depth), 4);  // no line crosses it, but pixels beside it are alike

  Frame normal = Step();
  normal.guides.normal = FlatNormal(kWidth, kHeight);
  ForEachPixel(kWidth, kHeight, [&](int x, int y) {
    const vec3 n = x < 30 ? vec3(1.0f, 0.0f, 0.0f) : vec3(0.0f, 1.0f, 0.0f);
    for (int c = 0; c < 3; ++c) {
      normal.guides.normal[c](x, y) = n[c];
    }
  });
  EstimateSecondMoments(&normal);
  EXPECT_LT(LargestVariance(normal), 1e-3);

  Frame id = Step();
  id.guides.id = Plane<uint32_t>(kWidth, kHeight);
  ForEachPixel(kWidth, kHeight, [&](int x, int y) { id.guides.id(x, y) = x < 30 ? 1 : 2; });
  EstimateSecondMoments(&id);
  EXPECT_LT(LargestVariance(id), 1e-3);
}

TEST(SecondMoments, EdgesInReflectionsAreNoNoiseOfSpecularLight) {
  const auto variance = [](SignalKind kind) {
    Frame frame = Step();
    frame.guides.specular_albedo = frame.guides.albedo;
    frame.signals[0].kind = kind;
    frame.reflection.depth = FlatDepth(kWidth, kHeight);
    frame.reflection.id = Plane<uint32_t>(kWidth, kHeight);
    ForEachPixel(kWidth, kHeight,
                 [&](int x, int y) { frame.reflection.id(x, y) = x < 30 ? 1 : 2; });
    // The step alone is straight, which no filter across it sees.
    SetLight(29, 20, 1.5f, &frame);
    EstimateSecondMoments(&frame);
    return VarianceOfSample(frame, 30, 20);
  };
  EXPECT_GT(variance(SignalKind::kDirectDiffuse), 1);
  EXPECT_LT(variance(SignalKind::kDirectSpecular), 1e-3);
}

TEST(SecondMoments, GuidesThatAreNoiseAreNotUsed) {
  // Random normals everywhere: no two pixels show one surface.
  Frame frame = OneBrightPixel();
  frame.guides.normal = FlatNormal(kWidth, kHeight);
  std::mt19937 random(3);
  std::normal_distribution<float> normal;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const vec3 n = normalize(vec3(normal(random), normal(random), normal(random)));
      for (int c = 0; c < 3; ++c) {
        frame.guides.normal[c](x, y) = n[c];
      }
    }
  }
  frame.guides.id = Plane<uint32_t>(kWidth, kHeight);
  ForEachPixel(kWidth, kHeight, [&](int x, int y) {
    frame.guides.id(x, y) = static_cast<uint32_t>(y * kWidth + x);
  });
  EstimateSecondMoments(&frame);
  // As by Immerkaer, over 5x5 blocks.
  EXPECT_NEAR(VarianceOfSample(frame, 20, 20), 36 / (25 * 36.0 / 16), 1e-4);
}

TEST(SecondMoments, NoiseOfAnyCountsHasTheVarianceOfItsSamples) {
  // Samples of variance 1 after the division by albedo, counts of 8 to 256 that change block by
  // block, over a slope.
  Frame frame = Grey(0);
  std::mt19937 random(7);
  std::normal_distribution<float> normal;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const float n = std::exp2(static_cast<float>(3 + (x / 4 + y / 4) % 6));
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
  EXPECT_GT(sum / (kWidth * kHeight), 1);  // pixels far from their neighbours have more
  EXPECT_LT(sum / (kWidth * kHeight), 1.15);
}

TEST(SecondMoments, SlopesHaveNone) {
  Frame frame = Grey(0);
  ForEachPixel(kWidth, kHeight, [&](int x, int y) {
    SetLight(x, y, 1 + 0.25f * static_cast<float>(x) + 0.5f * static_cast<float>(y), &frame);
  });
  EstimateSecondMoments(&frame);
  EXPECT_NEAR(VarianceOfSample(frame, 30, 30), 0, 1e-2);
  EXPECT_NEAR(VarianceOfSample(frame, 30, 0), 0, 1e-2);  // pairs along the picture's edge
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
