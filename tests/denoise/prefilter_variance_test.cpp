// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The vector stage against the scalar one: with and without knowing which blocks are full, at
// edges, and where the variance is nothing, or beyond all bounds.
#include "denoise/stages/prefilter_variance.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include "denoise/stages/prepare_guides.h"
#include "stage_planes.h"

namespace stillray::prefilter_variance_test {
namespace {

using test::kHeight;
using test::kWidth;

struct Signal {
  GuidePlanes guides = test::MakeGuides(true);
  Image1 luminance{kWidth, kHeight, 1};
  Image1 variance{kWidth, kHeight, 1};
  Image1 length{kWidth, kHeight};

  Signal() {
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        luminance(x, y) = 3 * test::Random(x, y, 30);
        variance(x, y) = std::exp2(60 * test::Random(x, y, 31) - 40);
        length(x, y) = std::floor(8 * test::Random(x, y, 32));
      }
    }
    for (int y = 10; y < 14; ++y) {  // wide enough for a mean of these alone
      for (int x = 20; x < 60; ++x) {
        variance(x, y) = x < 40 ? 0.0f : 3e38f;
      }
    }
    luminance(25, 12) = 0;
  }
  PrefilterVarianceInput Input(bool full) const {
    return {&luminance, &variance, &guides.inverse_depth, &length, full ? &guides.full : nullptr};
  }
};

void ExpectNear(const Image1& factor, const Image1& expected) {
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const float e = expected(x, y);
      EXPECT_NEAR(factor(x, y), e, 4e-6f * e + 1e-18f) << x << ", " << y;
    }
  }
}

TEST(PrefilterVariance, BlocksOfSurfaceAreFull) {
  const GuidePlanes guides = test::MakeGuides(true);
  int full = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int block = 0; block < BlocksOf(kWidth); ++block) {
      const int end = (block + 1) * kBlockPixels;
      bool all = true;
      for (int x = block * kBlockPixels; x < std::min(end, kWidth); ++x) {
        all = all && guides.inverse_depth(x, y) > 0;
      }
      // Beyond the row's end a block counts as far as the last vector reaches, which may be
      // nowhere.
      if (end <= kWidth || !all) {
        EXPECT_EQ(guides.full(block, y), all ? 1u : 0u) << block << ", " << y;
      }
      full += end <= kWidth && all ? 1 : 0;
    }
  }
  EXPECT_GT(full, 20);
}

TEST(PrefilterVariance, AsTheScalarStage) {
  const Signal signal;
  for (const int64_t target : hwy::SupportedAndGeneratedTargets()) {
    SCOPED_TRACE(hwy::TargetName(target));
    hwy::SetSupportedTargetsForTest(target);
    for (const bool smooth : {true, false}) {
      for (const bool square_root : {true, false}) {
        for (const float short_history_blur : {0.0f, 3.0f}) {
          PrefilterVarianceParameters p = test::DefaultPlan().prefilter_variance;
          p.prefilter_variance = smooth ? 1 : 0;
          p.luminance_scale_deviation = square_root ? 1 : 0;
          p.short_history_blur = short_history_blur;
          p.luminance_floor = smooth ? 0.2f : 0.0f;
          p.prefilter_limit = square_root ? 1.3f : 0.0f;
          Image1 expected(kWidth, kHeight);
          reference::PrefilterVariance(signal.Input(false), p, &expected);
          Image1 counted(kWidth, kHeight);
          cpu::PrefilterVariance(signal.Input(false), p, &counted);
          ExpectNear(counted, expected);
          Image1 known(kWidth, kHeight);
          cpu::PrefilterVariance(signal.Input(true), p, &known);
          EXPECT_EQ(test::DifferentBits(known, counted), 0);
        }
      }
    }
  }
  hwy::SetSupportedTargetsForTest(0);
}

TEST(PrefilterVariance, WithAConfidenceAsTheScalarStage) {
  const Signal signal;
  Image1 confidence(kWidth, kHeight);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      constexpr float kValues[] = {1, 0, 0.5f, 0.1f, 0.9f, -1, 2, NAN};
      confidence(x, y) = kValues[(x + y) % 8];
    }
  }
  PrefilterVarianceParameters p = test::DefaultPlan().prefilter_variance;
  p.volume_widening = 1.8f;
  PrefilterVarianceInput in = signal.Input(false);
  Image1 narrow(kWidth, kHeight);
  reference::PrefilterVariance(in, p, &narrow);
  in.confidence = &confidence;
  Image1 expected(kWidth, kHeight);
  reference::PrefilterVariance(in, p, &expected);
  int wider = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const bool sure = !(confidence(x, y) < 1);
      EXPECT_TRUE(sure ? expected(x, y) == narrow(x, y) : expected(x, y) <= narrow(x, y));
      wider += expected(x, y) < narrow(x, y) ? 1 : 0;
    }
  }
  EXPECT_GT(wider, kWidth * kHeight / 4);
  for (const int64_t target : hwy::SupportedAndGeneratedTargets()) {
    SCOPED_TRACE(hwy::TargetName(target));
    hwy::SetSupportedTargetsForTest(target);
    Image1 found(kWidth, kHeight);
    cpu::PrefilterVariance(in, p, &found);
    ExpectNear(found, expected);
  }
  hwy::SetSupportedTargetsForTest(0);
}

// A pixel whose neighbour, on another surface, has a thousand times its variance.
TEST(PrefilterVariance, NoiseOfANeighbourRaisesTheToleranceUpToALimit) {
  Signal signal;
  signal.luminance.Fill(0);
  signal.variance.Fill(0.04f);
  signal.variance(12, 30) = 40;
  ASSERT_GT(signal.guides.inverse_depth(11, 30), 0);
  PrefilterVarianceParameters p = test::DefaultPlan().prefilter_variance;
  p.luminance_floor = p.luminance_epsilon = 0;
  const auto tolerance = [&](float limit, int x) {
    p.prefilter_limit = limit;
    Image1 factor(kWidth, kHeight);
    reference::PrefilterVariance(signal.Input(false), p, &factor);
    return 1.4426950408889634 / static_cast<double>(factor(x, 30));
  };
  const double own = static_cast<double>(p.sigma_l) * 0.2;  // of the deviation
  EXPECT_GT(tolerance(0, 11), 8 * own);
  // g of the variance: 14 of its 16 weights are of the pixel's own surface.
  const double least = (14 * 0.04 + 2 * 40) / 16 / 64;
  EXPECT_NEAR(tolerance(2, 11), static_cast<double>(p.sigma_l) * std::sqrt(2 * 0.04 + least), 1e-4);
  EXPECT_NEAR(tolerance(1, 11), static_cast<double>(p.sigma_l) * std::sqrt(0.04 + least), 1e-4);
  EXPECT_NEAR(tolerance(2, 9), own, 1e-4);  // no such neighbour
  // Neighbours of less variance lower it.
  EXPECT_NEAR(tolerance(2, 12), tolerance(0, 12), 1e-4);
}

TEST(PrefilterVariance, LightOfVolumesHasAWiderTolerance) {
  EXPECT_FLOAT_EQ(VolumeWidening(1.0f, 2.0f), 1.0f);
  EXPECT_FLOAT_EQ(VolumeWidening(0.64f, 2.0f), 1.25f);
  EXPECT_FLOAT_EQ(VolumeWidening(0.16f, 2.0f), 2.0f);
  EXPECT_FLOAT_EQ(VolumeWidening(0.0f, 2.0f), 2.0f);
  EXPECT_FLOAT_EQ(VolumeWidening(0.16f, 1.0f), 1.0f);
}

TEST(SmoothVariance, AsTheScalarStage) {
  Signal signal;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      signal.variance(x, y) = std::min(signal.variance(x, y), 1e36f);  // whose sums are finite
    }
  }
  const Image1& valid = signal.guides.inverse_depth;
  Image1 expected(kWidth, kHeight);
  reference::SmoothVariance({&signal.variance, &valid}, &expected);
  for (const int64_t target : hwy::SupportedAndGeneratedTargets()) {
    SCOPED_TRACE(hwy::TargetName(target));
    hwy::SetSupportedTargetsForTest(target);
    Image1 counted(kWidth, kHeight);
    cpu::SmoothVariance({&signal.variance, &valid}, &counted);
    ExpectNear(counted, expected);
    Image1 known(kWidth, kHeight);
    cpu::SmoothVariance({&signal.variance, &valid, &signal.guides.full}, &known);
    EXPECT_EQ(test::DifferentBits(known, counted), 0);
  }
  hwy::SetSupportedTargetsForTest(0);
}

TEST(SmoothVariance, MeanOfPixelsWithLight) {
  Image1 variance(3, 3, 1);
  Image1 valid(3, 3, 1);
  for (int y = 0; y < 3; ++y) {
    for (int x = 0; x < 3; ++x) {
      variance(x, y) = static_cast<float>(1 + x + 3 * y);
      valid(x, y) = 1;
    }
  }
  valid(2, 0) = 0;
  Image1 smoothed(3, 3);
  reference::SmoothVariance({&variance, &valid}, &smoothed);
  // (1 + 2 * 2) + 2 * (4 + 2 * 5 + 6) + (7 + 2 * 8 + 9), weights 16 less that of the 3.
  EXPECT_FLOAT_EQ(smoothed(1, 1), 77.0f / 15);
  EXPECT_FLOAT_EQ(smoothed(0, 2), (4 * 7 + 2 * 4 + 2 * 8 + 5) / 9.0f);  // beside the edge
  EXPECT_EQ(smoothed(2, 0), 3.0f);                                      // without light: its own
}

}  // namespace
}  // namespace stillray::prefilter_variance_test
