// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The formulas that every version of a stage shares, against values worked out by hand or by
// another way in double precision.
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "core/colour_shared.h"
#include "denoise/stages/accumulate_shared.h"
#include "denoise/stages/antialias_shared.h"
#include "denoise/stages/edge_stopping_shared.h"
#include "denoise/stages/estimate_variance_shared.h"
#include "denoise/stages/limit_history_shared.h"
#include "denoise/stages/prepare_guides_shared.h"
#include "denoise/stages/reproject_shared.h"
#include "denoise/stages/select_guides_shared.h"
#include "denoise/stages/tonemap_shared.h"

namespace stillray::formulas_test {
namespace {

TEST(Formulas, NewFrameWeight) {
  EXPECT_EQ(NewFrameWeight(0, 1, 0.1f, false), 1.0f);  // no history: the new frame alone
  EXPECT_EQ(NewFrameWeight(0, 1, 0.2f, true), 1.0f);
  EXPECT_FLOAT_EQ(NewFrameWeight(1, 1, 0.1f, false), 0.5f);  // 1/age
  EXPECT_FLOAT_EQ(NewFrameWeight(3, 1, 0.1f, false), 0.25f);
  EXPECT_FLOAT_EQ(NewFrameWeight(6, 2, 0.1f, false), 0.25f);  // age in samples
  EXPECT_FLOAT_EQ(NewFrameWeight(99, 1, 0.1f, false), 0.1f);
  EXPECT_FLOAT_EQ(NewFrameWeight(1, 1, 0.2f, true), 0.2f);  // SVGF: constant from the start
  EXPECT_EQ(NewFrameWeight(5, 0, 0.1f, false), 0.0f);       // a missing sample changes nothing
}

/// Mean, variance and sum of squared weights of samples with explicit weights.
struct Weighted {
  double mean = 0;
  double variance = 0;
  double weights2 = 0;
};

Weighted ByWeights(const std::vector<double>& samples, const std::vector<double>& weights) {
  Weighted w;
  for (size_t i = 0; i < samples.size(); ++i) {
    w.mean += weights[i] * samples[i];
    w.weights2 += weights[i] * weights[i];
  }
  for (size_t i = 0; i < samples.size(); ++i) {
    w.variance += weights[i] * (samples[i] - w.mean) * (samples[i] - w.mean);
  }
  return w;
}

TEST(Formulas, RunningMomentsAreThoseOfTheWeightedSamples) {
  const std::vector<double> samples = {3, 0, 0, 7, 1, 2, 2, 0, 10, 4, 4.5, 0.25};
  for (const double alpha_min : {0.0, 0.2}) {
    std::vector<double> weights;
    double mean = 0;
    float variance = 0;
    float weights2 = 0;
    for (size_t i = 0; i < samples.size(); ++i) {
      const float alpha =
          NewFrameWeight(static_cast<float>(i), 1, static_cast<float>(alpha_min), false);
      for (double& w : weights) {
        w *= 1 - static_cast<double>(alpha);
      }
      weights.push_back(alpha);
      const double d = samples[i] - mean;
      variance = MixedVariance(variance, static_cast<float>(d), 0, alpha);
      weights2 = MixedWeights2(weights2, 1, alpha);
      mean += static_cast<double>(alpha) * d;
      const Weighted expected =
          ByWeights({samples.begin(), samples.begin() + static_cast<long>(i) + 1}, weights);
      EXPECT_NEAR(mean, expected.mean, 1e-5);
      EXPECT_NEAR(variance, expected.variance, 1e-4);
      EXPECT_NEAR(weights2, expected.weights2, 1e-5);
    }
  }
}

TEST(Formulas, VarianceDoesNotCancelOnBrightQuietPixels) {
  // 10000 +- 1: in float, E[x^2] - E[x]^2 would have lost every digit of the variance of 1.
  float mean = 0;
  float variance = 0;
  for (int i = 0; i < 200; ++i) {
    const float x = i % 2 == 0 ? 10001.0f : 9999.0f;
    const float alpha = NewFrameWeight(static_cast<float>(i), 1, 0, false);
    variance = MixedVariance(variance, x - mean, 0, alpha);
    mean += alpha * (x - mean);
  }
  EXPECT_NEAR(variance, 1.0f, 0.02f);
}

TEST(Formulas, SamplesWithinAPixelJoinAsIfTheyCameOneByOne) {
  const std::vector<double> first = {1, 5};
  const std::vector<double> second = {2, 2, 8, 4};
  const auto variance_of = [](const std::vector<double>& v) {
    return ByWeights(v, std::vector<double>(v.size(), 1.0 / static_cast<double>(v.size())));
  };
  const Weighted a = variance_of(first);
  const Weighted b = variance_of(second);
  const float alpha = NewFrameWeight(2, 4, 0, false);
  EXPECT_FLOAT_EQ(alpha, 4.0f / 6.0f);
  const Weighted all = variance_of({1, 5, 2, 2, 8, 4});
  EXPECT_NEAR(MixedVariance(static_cast<float>(a.variance), static_cast<float>(b.mean - a.mean),
                            static_cast<float>(b.variance), alpha),
              all.variance, 1e-5);
  EXPECT_NEAR(MixedWeights2(0.5f, 4, alpha), all.weights2, 1e-6);
}

TEST(Formulas, VarianceOfMean) {
  // Ten equal samples: s^2 = V * 10/9, of the mean s^2 / 10.
  EXPECT_NEAR(VarianceOfMean(0.9f, 0.1f), 0.1f, 1e-6f);
  EXPECT_FLOAT_EQ(VarianceOfMean(1.0f, 1.0f), 4.0f);  // one sample says nothing: bounded
  EXPECT_FLOAT_EQ(ShortHistoryBoost(2, 4, 1), 2.0f);
  EXPECT_FLOAT_EQ(ShortHistoryBoost(2, 4, 2), 4.0f);
  EXPECT_FLOAT_EQ(ShortHistoryBoost(2, 4, 0), 1.0f);
  EXPECT_FLOAT_EQ(ShortHistoryBoost(9, 4, 1), 1.0f);
}

TEST(Formulas, EdgeStoppingWeights) {
  EXPECT_NEAR(NormalWeight(0.99f, 128), std::pow(0.99, 128), 1e-5);
  EXPECT_EQ(NormalWeight(-0.5f, 128), 0.0f);
  // z = 2 and 2.5; slope of 1/z 0.1 per pixel along x, so dz = 0.1 * 4 * 3 pixels = 1.2.
  EXPECT_NEAR(GradientDepthExponent(0.5f, 0.4f, vec2(0.1f, 0), vec2(3, 7), 2, 0.01f, 0),
              0.5 / (2 * 1.2 + 0.02), 1e-6);
  EXPECT_EQ(GradientDepthExponent(0.5f, 0.4f, vec2(0.1f, 0), vec2(3, 7), 2, 0.01f, 0.19f), 0.0f);
  EXPECT_NEAR(PlaneDepthExponent(0.5f, 0.62f, vec2(0.04f, 0.01f), vec2(2, -1), 0.1f),
              std::abs(0.5 + 0.08 - 0.01 - 0.62) / 0.05, 1e-5);
  // One tolerance, 4 * 0.25 + 0.001 * 3, takes the weight to 1/e.
  EXPECT_NEAR(std::exp2(-1.003 * LuminanceFactor(3, 0.25f, 4, 0.001f, 0)), std::exp(-1.0), 1e-6);
  // A floor of 0.5 is added to it, whatever the luminance.
  EXPECT_NEAR(std::exp2(-1.503 * LuminanceFactor(3, 0.25f, 4, 0.001f, 0.5f)), std::exp(-1.0), 1e-6);
  EXPECT_NEAR(std::exp2(-0.5 * LuminanceFactor(0, 0, 4, 0.001f, 0.5f)), std::exp(-1.0), 1e-6);
  EXPECT_NEAR(EawExponent(0.04f, 0.09f, 0.01f, 0.5f, 0.3f, 0.2f), 0.16 + 1 + 0.25, 1e-6);
}

TEST(Formulas, PlaneWeightIsExactOnAnySlope) {
  // A ray through pixel (x, y) meets the plane n . p = d at z = d / (n . (x, y, 1) k).
  const auto inverse_depth = [](double x, double y) { return (0.3 * x - 0.7 * y + 900) / 2000; };
  const vec2 gradient(0.3f / 2000, -0.7f / 2000);
  for (const auto& [dx, dy] : {std::pair{16.0, 0.0}, {-32.0, 32.0}, {5.0, -7.0}}) {
    EXPECT_NEAR(PlaneDepthExponent(static_cast<float>(inverse_depth(100, 50)),
                                   static_cast<float>(inverse_depth(100 + dx, 50 + dy)), gradient,
                                   vec2(dx, dy), 1e-3f),
                0, 1e-3);
  }
}

// The distance of points of a camera that is turned by any angles, in double precision.
TEST(Formulas, PositionWeightIsTheDistanceInSpace) {
  EdgeStopping e = {};
  e.depth_weight_position = 1;
  e.position_sigma = 0.05f;
  e.focal_pixels = 935.3f;
  e.centre_x = 640;
  e.centre_y = 360.5f;
  const double f = static_cast<double>(e.focal_pixels);
  const auto position = [&](double x, double y, double z) {
    const glm::dvec3 p((x + 0.5 - 640) * z / f, (y + 0.5 - 360.5) * z / f, z);
    const double c = std::cos(0.7);
    const double s = std::sin(0.7);
    return glm::dvec3(c * p.x + s * p.z, p.y, c * p.z - s * p.x) + glm::dvec3(3, -2, 9);
  };
  for (const auto& [x, y] : {std::pair{0, 0}, {639, 360}, {1279, 50}}) {
    for (const auto& [dx, dy] : {std::pair{1, 0}, {-32, 16}, {5, -7}}) {
      for (const double zp : {0.01, 4.0, 3e4}) {
        for (const double ratio : {1.0, 1.0001, 0.97, 1.5}) {
          const glm::dvec3 d = position(x, y, zp) - position(x + dx, y + dy, zp * ratio);
          const double expected = glm::dot(d, d) / std::pow(0.05 * zp, 2);
          const float found =
              DepthExponent(e, static_cast<float>(1 / zp), static_cast<float>(1 / (zp * ratio)),
                            vec2(0.0f), vec2(x, y), vec2(dx, dy));
          EXPECT_NEAR(static_cast<double>(found), expected, 2e-4 * expected + 1e-9);
        }
      }
    }
  }
  EXPECT_EQ(DepthExponent(e, 0.5f, 0.0f, vec2(0.0f), vec2(3, 4), vec2(1, 0)), kNeverSimilar);
}

TEST(Formulas, SharedLuminanceFactor) {
  EXPECT_EQ(SharedLuminanceFactor(6, 2, 1), 6.0f);  // the papers': the pixel's own
  EXPECT_EQ(SharedLuminanceFactor(6, 2, 1.5f),
            4.0f);  // lowered for a noisier neighbour, but bounded
  EXPECT_EQ(SharedLuminanceFactor(6, 5, 1.5f), 5.0f);
  EXPECT_EQ(SharedLuminanceFactor(6, 9, 1.5f), 6.0f);  // never raised
  EXPECT_EQ(SharedLuminanceFactor(0, 9, 1.5f), 0.0f);
}

TEST(Formulas, GreenFromLuminance) {
  EXPECT_NEAR(Green709(Luminance709(0.3f, 0.7f, 0.2f), 0.3f, 0.2f), 0.7f, 1e-6);
  EXPECT_NEAR(Green601(Luminance601(0.3f, 0.7f, 0.2f), 0.3f, 0.2f), 0.7f, 1e-6);
  EXPECT_EQ(Green709(0, 1e-9f, 0), 0.0f);  // rounding makes no negative light
}

TEST(Formulas, CompressedLuminance) {
  EXPECT_FLOAT_EQ(CompressLuminance(3, 3), 0.5f);
  EXPECT_FLOAT_EQ(CompressLuminance(9, 1), 0.9f);
  EXPECT_EQ(CompressLuminance(0, 1), 0.0f);
  for (const float l : {0.0f, 0.1f, 1.0f, 50.0f}) {
    EXPECT_NEAR(RescaleCompressed(CompressLuminance(l, 2), 2, 0.5f), CompressLuminance(l, 0.5f),
                1e-6f);
  }
  // Small noise: the slope of l / (l + 1) at 1 is 1/4.
  EXPECT_NEAR(CompressedVariance(0.5f, 1, 0.01f, 1), 0.01 / 16, 1e-7);
  // Samples 0 and 10, one in twenty: c is 0 or 10/11; the bound is close, the slope far off.
  const double c1 = 10.0 / 11;
  const double mean_c = c1 / 20;
  const double exact = mean_c * c1 - mean_c * mean_c;
  const float estimate = CompressedVariance(static_cast<float>(mean_c), 0.5f, 4.75f, 1);
  EXPECT_GE(estimate, exact);
  EXPECT_LT(estimate, 1.15 * exact);
  // The least scale there is, of a history of nothing but black: no variance, and no NaN.
  EXPECT_EQ(CompressedVariance(0, 0, 0, 1e-20f), 0.0f);
  EXPECT_NEAR(CompressedVariance(0.5f, 1e-20f, 1e-41f, 1e-20f), 1e-41 / 16 * 1e40, 1e-3);
}

TEST(Formulas, LimitedLength) {
  // Within (1 + dead) variances of the expected noise nothing happens.
  EXPECT_EQ(RelativeBias(0.29f, 0.01f, 0.2f, 8), 0.0f);
  EXPECT_EQ(LimitedLength(20, 0.05f, 0, 4), 20.0f);
  // d^2 = 0.16 exceeds 0.09 by 0.07: 1 / (0.05 + 4 * 0.07 / 0.2).
  const float bias = RelativeBias(0.4f, 0.01f, 0.2f, 8);
  EXPECT_NEAR(bias, 0.07 / 0.2, 1e-6);
  EXPECT_NEAR(LimitedLength(20, 0.05f, bias, 4), 1 / (0.05 + 1.4), 1e-4);
  EXPECT_EQ(LimitedLength(0.5f, 0.05f, bias, 4), 0.5f);  // never raised
}

TEST(Formulas, MovingLight) {
  // Two deviations, and a twentieth of the light.
  EXPECT_FALSE(HasChanged(1.39f, 1, 0.04f));
  EXPECT_TRUE(HasChanged(1.41f, 1, 0.04f));
  EXPECT_TRUE(HasChanged(0.59f, 1, 0.04f));
  EXPECT_FALSE(HasChanged(1.049f, 1, 0));
  EXPECT_TRUE(HasChanged(1.051f, 1, 0));
  EXPECT_FALSE(HasChanged(0, 0, 0));
  // Shares of diffuse and of other light, by hand.
  EXPECT_EQ(MovingLight(30000, 100000, true), 0.0f);
  EXPECT_NEAR(MovingLight(40000, 100000, true), 0.5, 1e-5);
  EXPECT_EQ(MovingLight(50000, 100000, true), 1.0f);
  EXPECT_NEAR(MovingLight(15000, 100000, false), 0.5, 1e-5);
  EXPECT_EQ(MovingLight(10000, 100000, false), 0.0f);
  EXPECT_EQ(MovingLight(25000, 100000, false), 1.0f);
  // Of a small picture all blocks have common noise.
  EXPECT_NEAR(MovingLight(729, 729, true), 1.0 / 16, 1e-6);
  EXPECT_EQ(MovingLight(0, 0, true), 0.0f);
  EXPECT_EQ(DeadZone(4, 0), 4.0f);
  EXPECT_NEAR(DeadZone(4, 0.5f), 2.3, 1e-6);
  EXPECT_NEAR(DeadZone(4, 1), 0.6, 1e-6);
  EXPECT_EQ(DeadZone(0, 1), 0.0f);
  EXPECT_EQ(RatioNoise(0), 1.75f);
  EXPECT_EQ(RatioNoise(1), 1.0f);
}

TEST(Formulas, HistoryRatio) {
  // Without noise it is the plain ratio, within its bounds.
  EXPECT_NEAR(HistoryRatio(1.5f, 1, 0, 0), 1.5, 1e-6);
  EXPECT_EQ(HistoryRatio(9, 1, 0, 0), kMostRatio);
  EXPECT_EQ(HistoryRatio(0.1f, 1, 0, 0), 1 / kMostRatio);
  // d^2 = 0.25, 1.75 variances of 0.05: 1 - 0.0875 / 0.25 of the difference.
  EXPECT_NEAR(HistoryRatio(1.5f, 1, 0.05f, 0), 1 + 0.65 * 0.5, 1e-6);
  EXPECT_EQ(HistoryRatio(1.5f, 1, 0.2f, 0), 1.0f) << "noise";
  EXPECT_NEAR(HistoryRatio(1.5f, 1, 0.05f, 1), 1 + 0.8 * 0.5, 1e-6) << "light moves";
  EXPECT_EQ(HistoryRatio(1.5f, 0, 0, 0), 1.0f) << "there is nothing to scale";
  EXPECT_EQ(HistoryRatio(0, 0, 0, 0), 1.0f);
}

TEST(Formulas, ComparisonNoise) {
  // Samples of variance 0.19 in a mean of twenty (sum of squared weights 0.05), unbiased: 0.2.
  // Twenty samples: the square root of 20 / 8.
  const double caution = 1.5811388;
  EXPECT_NEAR(ComparisonNoise(2.1f, 1, 20, 2, 0.19f, 0.05f), caution * 0.2 * 1.05, 1e-6);
  EXPECT_NEAR(ComparisonNoise(2.1f, 4, 20, 2, 0.19f, 0.05f), 0.2 * (0.25 + 0.05), 1e-6)
      << "five frames of four samples are not steady";
  EXPECT_NEAR(ComparisonNoise(2.1f, 4, 80, 2, 0.19f, 0.05f), caution * 0.2 * (0.25 + 0.05), 1e-6)
      << "twenty frames";
  EXPECT_NEAR(ComparisonNoise(3, 1, 20, 2, 0.19f, 0.05f), caution, 1e-6) << "the difference itself";
  EXPECT_NEAR(ComparisonNoise(2.1f, 1, 8, 2, 0.19f, 0.05f), 0.2 * 1.05, 1e-6);
  EXPECT_EQ(ComparisonNoise(3, 1, 2, 2.5f, 0.19f, 0.5f), 0.25f) << "a short history has no other";
}

TEST(Formulas, CompressedNoise) {
  // Samples of variance 0.02 and a history whose squared weights have the sum 0.05.
  const float one = SpreadOfDifference(1, 0.05f);
  const float four = SpreadOfDifference(4, 0.05f);
  EXPECT_NEAR(CompressedNoise(0.1f, 0.02f, one, 0.25f), 0.02 * 1.05, 1e-7);
  EXPECT_NEAR(CompressedNoise(0.1f, 0.02f, four, 0.25f), 0.02 * 0.3, 1e-7);
  EXPECT_NEAR(CompressedNoise(-0.4f, 0.02f, one, 0.25f), 0.25 * 0.16, 1e-7) << "a share";
  EXPECT_NEAR(CompressedNoise(-0.4f, 0.02f, one, 1), 0.16, 1e-7) << "all of the difference";
}

TEST(Formulas, ShareOfChange) {
  EXPECT_EQ(ShareOfChange(0, 20), 0.25f);
  EXPECT_EQ(ShareOfChange(1, 20), 0.25f) << "the roughest surface";
  EXPECT_EQ(ShareOfChange(kRoughnessOfImage, 20), 1);
  EXPECT_EQ(ShareOfChange(std::numeric_limits<float>::quiet_NaN(), 20), 0.25f);
  EXPECT_EQ(ShareOfChange(0, 4), 0.25f);
  EXPECT_NEAR(ShareOfChange(0, 3), 0.5, 1e-3) << "a short history";
  EXPECT_NEAR(ShareOfChange(0, 3.5f), 0.375, 1e-3);
  EXPECT_EQ(ShareOfChange(kRoughnessOfImage, 3), 1);
}

TEST(Formulas, SingleVariance) {
  // Two frames: the difference has the variance of 1 + 1/2 samples, of which a tenth counts.
  EXPECT_NEAR(SingleVariance(-0.3f, 0, 2, 1.5f), 0.1 * 0.09 / 1.5, 1e-7);
  EXPECT_EQ(SingleVariance(-0.3f, 0.02f, 2, 1.5f), 0.02f) << "the moments' is larger";
  EXPECT_EQ(SingleVariance(-0.3f, 1e-4f, 4, 1.25f), 1e-4f) << "long enough for the moments";
}

TEST(Formulas, BiasOfFrame) {
  // Four samples have a quarter of the variance.
  EXPECT_EQ(BiasOfFrame(0.5f, 4), 2);
  EXPECT_EQ(BiasOfFrame(0.5f, 1), 0.5f);
  EXPECT_EQ(BiasOfFrame(0.5f, 0), 0.5f) << "the least that a frame has";
  EXPECT_EQ(BiasOfFrame(kMostBias, 64), kMostBias) << "halves hold it";
}

TEST(Formulas, ScaledCompressed) {
  for (const float l : {0.0f, 0.1f, 1.0f, 30.0f}) {
    for (const float ratio : {0.5f, 1.0f, 1.7f}) {
      EXPECT_NEAR(ScaledCompressed(CompressLuminance(l, 0.7f), ratio),
                  CompressLuminance(l * ratio, 0.7f), 1e-6);
    }
  }
}

TEST(Formulas, SameSurface) {
  const vec2 flat(0, 0);
  EXPECT_TRUE(IsSameSurface(0.5f, 0.52f, flat, 1, 3, 3, 0.05f, 0.9f, true));
  EXPECT_FALSE(IsSameSurface(0.5f, 0.53f, flat, 1, 3, 3, 0.05f, 0.9f, true));
  EXPECT_TRUE(IsSameSurface(0.5f, 0.53f, vec2(0.01f, 0), 1, 3, 3, 0.05f, 0.9f, true));
  EXPECT_FALSE(IsSameSurface(0.5f, 0.5f, flat, 0.89f, 3, 3, 0.05f, 0.9f, true));
  EXPECT_FALSE(IsSameSurface(0.5f, 0.5f, flat, 1, 3, 4, 0.05f, 0.9f, true));
  EXPECT_TRUE(IsSameSurface(0.5f, 0.5f, flat, 1, 3, 4, 0.05f, 0.9f, false));
  EXPECT_TRUE(IsSameSurface(0.5f, 0.5f, flat, 1, 0, 4, 0.05f, 0.9f, true));    // 0: not known
  EXPECT_FALSE(IsSameSurface(0.5f, 0.0f, flat, 1, 3, 3, 100.0f, 0.9f, true));  // nothing there
}

TEST(Formulas, OneSidedGradient) {
  EXPECT_FLOAT_EQ(OneSidedGradient(1, 2, 9, 1, 1), 1.0f);  // the smaller: 9 lies beyond an edge
  EXPECT_FLOAT_EQ(OneSidedGradient(1, 2, 9, 0, 1), 7.0f);
  EXPECT_FLOAT_EQ(OneSidedGradient(1, 2, 9, 1, 0), 1.0f);
  EXPECT_EQ(OneSidedGradient(1, 2, 9, 0, 0), 0.0f);
}

TEST(Formulas, CatmullRomReproducesParabolas) {
  for (const float t : {0.0f, 0.25f, 0.5f, 0.9f}) {
    const vec4 w = CatmullRom(t);
    double sum = 0;
    double line = 0;
    double parabola = 0;
    for (int i = 0; i < 4; ++i) {
      const double x = i - 1;
      sum += w[i];
      line += w[i] * x;
      parabola += w[i] * x * x;
    }
    EXPECT_NEAR(sum, 1, 1e-6);
    EXPECT_NEAR(line, t, 1e-6);
    EXPECT_NEAR(parabola, static_cast<double>(t) * t, 1e-6);
  }
  EXPECT_FLOAT_EQ(CatmullRom(0.5f)[0], -0.0625f);
  EXPECT_FLOAT_EQ(CatmullRom(0.5f)[1], 0.5625f);
}

TEST(Formulas, ToneCurves) {
  EXPECT_FLOAT_EQ(ToneCurve(0.25f, 0), 0.25f);
  EXPECT_EQ(ToneCurve(7, 0), 1.0f);
  EXPECT_FLOAT_EQ(ToneCurve(3, 1), 0.75f);
  EXPECT_NEAR(ToneCurve(5.6f, 2), 1.0f, 1e-6f);  // white at 11.2, exposed by 2
  EXPECT_NEAR(ToneCurve(0, 2), 0.0f, 1e-6f);
  const double s = 0.6 * 0.5;
  EXPECT_NEAR(ToneCurve(0.5f, 3), s * (2.51 * s + 0.03) / (s * (2.43 * s + 0.59) + 0.14), 1e-6);
  for (int curve = 0; curve < 4; ++curve) {
    float last = -1;
    for (float x = 0; x < 20; x += 0.01f) {
      const float y = ToneCurve(x, curve);
      EXPECT_GE(y, last);
      EXPECT_LE(y, 1.0f);
      last = y;
    }
  }
}

TEST(Formulas, ColourCurves) {
  EXPECT_FLOAT_EQ(Luminance709(1, 1, 1), 1.0f);
  EXPECT_FLOAT_EQ(Luminance601(1, 1, 1), 1.0f);
  EXPECT_FLOAT_EQ(Luminance709(0, 1, 0), 0.7152f);
  EXPECT_FLOAT_EQ(Luminance601(0, 1, 0), 0.587f);
  EXPECT_NEAR(SrgbEncode(0.5f), 0.735357, 1e-6);
  EXPECT_NEAR(SrgbEncode(0.002f), 0.02584, 1e-7);
  for (float x = 0; x <= 1; x += 0.05f) {
    EXPECT_NEAR(SrgbDecode(SrgbEncode(x)), x, 1e-6f);
  }
  for (const float albedo : {0.0f, 0.005f, 0.3f, 1.0f}) {
    EXPECT_NEAR(Remodulate(Demodulate(0.7f, albedo), albedo), 0.7f, 1e-6f);
  }
  EXPECT_FLOAT_EQ(Demodulate(0.5f, 0.0f), 50.0f);
}

TEST(EdgeStopping, CurvedSurfacesAcceptTheirNeighbours) {
  constexpr float kLeast = 8;
  EXPECT_EQ(CurvedSigmaN(64, 0, 0.5f, kLeast), 64);
  EXPECT_NEAR(CurvedSigmaN(64, 0.01f, 0.5f, kLeast), 64 / (1 + 0.5 * 64 * 0.01), 1e-4);
  EXPECT_EQ(CurvedSigmaN(64, 1, 0.5f, kLeast), kLeast);
  EXPECT_EQ(CurvedSigmaN(4, 1, 0.5f, kLeast), 4) << "never above sigma_n";
  EdgeStopping edges = {};
  edges.sigma_n = 64;
  for (const double angle : {0.0, 0.05, 0.2, 0.5}) {
    const double cosine = std::cos(angle);
    EXPECT_NEAR(NormalWeightAt(edges, static_cast<float>(cosine), 0.04f, kLeast),
                std::pow(cosine, 64), 1e-5);
    edges.curvature = 0.5f;
    const double exponent = 64 / (1 + 0.5 * 64 * 0.04);
    // The logarithm to second order: off by (1 - c)^3 / 3.
    const double bound = exponent * std::pow(1 - cosine, 3) / 2 + 1e-5;
    EXPECT_NEAR(NormalWeightAt(edges, static_cast<float>(cosine), 0.04f, kLeast),
                std::pow(cosine, exponent), bound);
    edges.curvature = 0;
  }
}

}  // namespace
}  // namespace stillray::formulas_test
