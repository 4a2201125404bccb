// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/stages/estimate_variance.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "stage_test.h"

namespace stillray::estimate_variance_test {
namespace {

constexpr int kBorder = 16;
constexpr int kWidth = 19;
constexpr int kHeight = 9;

using Version = decltype(&cpu::EstimateVariance);
constexpr Version kVersions[] = {&reference::EstimateVariance, &cpu::EstimateVariance};

EstimateVarianceParameters MakeParameters() {
  EstimateVarianceParameters p = {};
  p.edges.sigma_n = 128;
  p.edges.depth_weight_plane = 1;
  p.edges.sigma_z = 1;
  p.edges.plane_tolerance = 0.01f;
  p.edges.depth_epsilon = 0.001f;
  p.variance_of_mean = 1;
  p.short_history = kShortHistorySpread;
  p.short_history_length = 4;
  p.short_history_radius = 3;
  return p;
}

/// A wall that faces the camera.
GuidePlanes MakeWall(int width = kWidth, int height = kHeight) {
  GuidePlanes guides(width, height, kBorder);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      guides.inverse_depth(x, y) = 0.25f;
      guides.depth(x, y) = 4;
      guides.normal[2](x, y) = 1;
      guides.id(x, y) = 1;
    }
  }
  return guides;
}

/// Histories of the same length everywhere.
SignalHistory MakeHistory(float length, float variance, float weights2,
                          const std::function<float(int, int)>& mean) {
  SignalHistory history(kWidth, kHeight);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      history.mean(x, y) = mean(x, y);
      history.variance(x, y) = variance;
      history.length(x, y) = length;
      history.weights2(x, y) = weights2;
    }
  }
  return history;
}

struct Estimate {
  Image1 variance{kWidth, kHeight};
  bool all_valid = false;
};

Estimate RunStage(Version estimate_variance, const SignalHistory& history,
                  const GuidePlanes& guides, const EstimateVarianceParameters& p,
                  const Image1* samples = nullptr) {
  Estimate out;
  VarianceSignal signal = {&history, samples, &out.variance};
  estimate_variance({&signal, 1}, guides, p);
  out.all_valid = signal.all_valid;
  return out;
}

float Half(int x, int) {
  return x < 8 ? 1.0f : 1000.0f;
}

TEST(EstimateVariance, LongHistoriesHaveTheirOwn) {
  const SignalHistory history = MakeHistory(9, 3, 0.2f, Half);
  Image1 samples(kWidth, kHeight);
  samples.Fill(4);
  EstimateVarianceParameters p = MakeParameters();
  for (const Version version : kVersions) {
    p.variance_of_mean = 1;
    const Estimate of_mean = RunStage(version, history, MakeWall(), p);
    EXPECT_TRUE(of_mean.all_valid);
    EXPECT_NEAR(of_mean.variance(7, 4), 3 / 0.8 * 0.2, 1e-6);  // unbiased, of the mean
    p.variance_of_mean = 0;
    EXPECT_FLOAT_EQ(RunStage(version, history, MakeWall(), p).variance(7, 4), 3);
    EXPECT_FLOAT_EQ(RunStage(version, history, MakeWall(), p, &samples).variance(7, 4), 0.75f);
  }
}

TEST(EstimateVariance, ShortHistoriesHaveThatOfTheirNeighbourhood) {
  // Means of 0 and 2 in turns: of the 49 pixels around one, 25 are like it. Of each, samples vary
  // by 0.5 about the mean.
  const SignalHistory history =
      MakeHistory(1, 0.5f, 1, [](int x, int y) { return (x + y) % 2 == 0 ? 0.0f : 2.0f; });
  const double between = 4 * (24.0 / 49) * (25.0 / 49);
  EstimateVarianceParameters p = MakeParameters();
  for (const Version version : kVersions) {
    p.short_history_boost = 0;
    EXPECT_NEAR(RunStage(version, history, MakeWall(), p).variance(7, 4), between + 0.5, 1e-5);
    p.short_history_boost = 1;  // times 4 samples that are wanted / 1 that is there
    EXPECT_NEAR(RunStage(version, history, MakeWall(), p).variance(7, 4), 4 * (between + 0.5),
                1e-4);
    p.short_history = kShortHistoryNone;
    EXPECT_EQ(RunStage(version, history, MakeWall(), p).variance(7, 4), 0);
    p.short_history = kShortHistorySpread;
  }
}

TEST(EstimateVariance, TheNeighbourhoodMayHave5x5Pixels) {
  // 13 of 25 pixels are like the one in their middle; what lies further away has no effect.
  const SignalHistory history = MakeHistory(1, 0.5f, 1, [](int x, int y) {
    const bool far = std::abs(x - 7) > 2 || std::abs(y - 4) > 2;
    return far ? 1e3f : (x + y) % 2 == 0 ? 0.0f : 2.0f;
  });
  EstimateVarianceParameters p = MakeParameters();
  p.short_history_radius = 2;
  for (const Version version : kVersions) {
    EXPECT_NEAR(RunStage(version, history, MakeWall(), p).variance(7, 4),
                4 * (12.0 / 25) * (13.0 / 25) + 0.5, 1e-5);
  }
}

TEST(EstimateVariance, SecondDifferencesTakeNoSlopeForNoise) {
  EstimateVarianceParameters p = MakeParameters();
  p.short_history_radius = 2;
  // A steep ramp has no second differences. The variance of -2..2 is 2, and the spread of the ramp
  // (1 + 9) times that, of which kSpreadWeight beside 30 lines is left.
  const SignalHistory ramp = MakeHistory(
      1, 0, 1, [](int x, int y) { return static_cast<float>(x) + 3 * static_cast<float>(y); });
  const double spread = 2.0 * (1 + 9);
  // Means of 0 and 2 in turns: every second difference is 4 or -4.
  const SignalHistory checks =
      MakeHistory(1, 0.5f, 1, [](int x, int y) { return (x + y) % 2 == 0 ? 0.0f : 2.0f; });
  const double of_checks = 4 * (12.0 / 25) * (13.0 / 25);
  for (const Version version : kVersions) {
    p.short_history = kShortHistorySpread;
    EXPECT_NEAR(RunStage(version, ramp, MakeWall(), p).variance(9, 4), spread, 1e-4);
    p.short_history = kShortHistorySecondDifference;
    EXPECT_NEAR(RunStage(version, ramp, MakeWall(), p).variance(9, 4), 0.05 * spread / 30.05, 1e-4);
    EXPECT_NEAR(RunStage(version, checks, MakeWall(), p).variance(7, 4),
                (30 * 16 / 6.0 + 0.05 * of_checks) / 30.05 + 0.5, 1e-4);
  }
}

TEST(EstimateVariance, SecondDifferencesHaveTheVarianceOfNoise) {
  EstimateVarianceParameters p = MakeParameters();
  p.short_history = kShortHistorySecondDifference;
  p.short_history_radius = 2;
  for (const Version version : kVersions) {
    double sum = 0;
    for (uint32_t seed = 0; seed < 40; ++seed) {
      // Uniform, of variance 3, on a slope.
      const SignalHistory noise = MakeHistory(1, 0, 1, [&](int x, int y) {
        return 6 * test::RandomAt(x, y, seed) + 2 * static_cast<float>(x);
      });
      for (const int x : {2, 8, 14}) {
        sum += RunStage(version, noise, MakeWall(), p).variance(x, 4) / (3 * 40);
      }
    }
    EXPECT_NEAR(sum, 3, 0.3);
  }
}

TEST(EstimateVariance, ThinSurfacesHaveTheirSpread) {
  // Two diagonal pixels: no three of the surface lie in a line.
  GuidePlanes guides = MakeWall();
  const auto on_line = [](int x, int y) { return x + y == 11 && y >= 4 && y <= 5; };
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      guides.inverse_depth(x, y) = on_line(x, y) ? 0.5f : 0.25f;
      guides.depth(x, y) = 1 / guides.inverse_depth(x, y);
    }
  }
  const SignalHistory history = MakeHistory(1, 0, 1, [&](int x, int y) {
    return !on_line(x, y) ? 1e3f : y == 4 ? 1.0f : 3.0f;
  });
  EstimateVarianceParameters p = MakeParameters();
  p.short_history = kShortHistorySecondDifference;
  for (const Version version : kVersions) {
    EXPECT_NEAR(RunStage(version, history, guides, p).variance(7, 4), 1, 1e-4);
  }
}

TEST(EstimateVariance, NothingLeaksOverEdges) {
  GuidePlanes depth = MakeWall();
  GuidePlanes normal = MakeWall();
  for (int y = 0; y < kHeight; ++y) {
    std::fill(depth.inverse_depth.Row(y) + 8, depth.inverse_depth.Row(y) + kWidth, 0.5f);
    std::fill(depth.depth.Row(y) + 8, depth.depth.Row(y) + kWidth, 2.0f);
    std::fill(normal.normal[2].Row(y) + 8, normal.normal[2].Row(y) + kWidth, 0.0f);
    std::fill(normal.normal[0].Row(y) + 8, normal.normal[0].Row(y) + kWidth, 1.0f);
  }
  const SignalHistory history = MakeHistory(1, 0, 1, Half);
  EstimateVarianceParameters p = MakeParameters();
  for (const int kind : {kShortHistorySpread, kShortHistorySecondDifference}) {
    p.short_history = kind;
    for (const Version version : kVersions) {
      EXPECT_GT(RunStage(version, history, MakeWall(), p).variance(7, 4), 1e4f);
      for (const GuidePlanes* guides : {&depth, &normal}) {
        const Estimate estimate = RunStage(version, history, *guides, p);
        for (int x = 0; x < kWidth; ++x) {
          EXPECT_LT(estimate.variance(x, 4), 1e-12f) << x;
        }
      }
    }
  }
}

TEST(EstimateVariance, TooLittleEvidenceIsUnknown) {
  const SignalHistory history = MakeHistory(1, 0.5f, 1, Half);
  EstimateVarianceParameters p = MakeParameters();
  p.least_evidence = 30;  // 49 pixels around the centre, 16 at a corner
  for (const Version version : kVersions) {
    const Estimate estimate = RunStage(version, history, MakeWall(), p);
    EXPECT_LT(estimate.variance(4, 4), 1e7f);
    EXPECT_FLOAT_EQ(estimate.variance(0, 0), kUnknownVariance);
  }
}

TEST(EstimateVariance, NoLightOrSurfaceHasNone) {
  SignalHistory history = MakeHistory(9, 3, 0.2f, Half);
  GuidePlanes guides = MakeWall();
  guides.inverse_depth(5, 4) = 0;
  history.length(5, 4) = 0;  // there is no surface: the picture is complete
  for (const Version version : kVersions) {
    const Estimate sky = RunStage(version, history, guides, MakeParameters());
    EXPECT_EQ(sky.variance(5, 4), 0);
    EXPECT_TRUE(sky.all_valid);
  }
  history.length(6, 4) = 0;
  for (const Version version : kVersions) {
    const Estimate hole = RunStage(version, history, guides, MakeParameters());
    EXPECT_EQ(hole.variance(6, 4), 0);
    EXPECT_GT(hole.variance(7, 4), 0);
    EXPECT_FALSE(hole.all_valid);
  }
}

TEST(EstimateVariance, VectorsMatchTheReference) {
  test::ForSizesAndTargets([](int width, int height) {
    GuidePlanes guides = MakeWall(width, height);
    guides.turn2 = Image1(width, height);
    SignalHistory history(width, height);
    Image1 samples(width, height);
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        guides.inverse_depth(x, y) = test::RandomAt(x, y, 1) < 0.1f
                                         ? 0.0f
                                         : 0.25f + 0.001f * test::RandomAt(x / 9, y / 5, 2);
        const float i = guides.inverse_depth(x, y);
        guides.depth(x, y) = i > 0 ? 1 / i : 0.0f;
        guides.gradient[0](x, y) = 1e-4f;
        guides.normal[0](x, y) = std::sin(0.2f * test::RandomAt(x, y, 7));
        guides.normal[2](x, y) = std::cos(0.2f * test::RandomAt(x, y, 7));
        guides.turn2(x, y) = 0.05f * test::RandomAt(x, y, 8);
        const float length = std::floor(8 * test::RandomAt(x, y, 3));
        history.length(x, y) = length;
        history.mean(x, y) = length > 0 ? 3 * test::RandomAt(x, y, 4) : 0.0f;
        history.variance(x, y) = length > 0 ? test::RandomAt(x, y, 5) : 0.0f;
        history.weights2(x, y) = length > 0 ? 1 / length : 0.0f;
        samples(x, y) = std::floor(4 * test::RandomAt(x, y, 6));
      }
    }
    enum { kGradient, kPlane, kPosition };
    for (const int of_mean : {0, 1}) {
      for (const int kind : {kGradient, kPlane, kPosition}) {
        EstimateVarianceParameters p = MakeParameters();
        p.edges.curvature = kind == kGradient ? 0.0f : 0.5f;
        p.variance_of_mean = of_mean;
        p.edges.depth_weight_plane = kind == kPlane ? 1 : 0;
        p.edges.depth_weight_position = kind == kPosition ? 1 : 0;
        p.edges.position_sigma = 0.2f;
        p.edges.focal_pixels = 20;
        p.edges.centre_x = 0.5f * static_cast<float>(width);
        p.edges.centre_y = 0.5f * static_cast<float>(height);
        p.short_history_boost = 1;
        p.short_history_radius = 3 - of_mean;
        p.short_history = kind == kPosition ? kShortHistorySpread : kShortHistorySecondDifference;
        p.least_evidence = 1.5f;
        Image1 expected(width, height);
        Image1 got(width, height);
        VarianceSignal expected_signal = {&history, &samples, &expected};
        VarianceSignal signal = {&history, &samples, &got};
        reference::EstimateVariance({&expected_signal, 1}, guides, p);
        cpu::EstimateVariance({&signal, 1}, guides, p);
        EXPECT_EQ(signal.all_valid, expected_signal.all_valid);
        // The approximated exponential (1.5e-5), in a difference of two sums.
        test::ExpectNear(got, expected, 1e-4, 1e-4);
      }
    }
  });
}

}  // namespace
}  // namespace stillray::estimate_variance_test
