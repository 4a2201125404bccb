// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// keep_samples: the stage on computed planes, and the denoiser on a wall with light of fine detail.
#include "denoise/stages/keep_samples.h"

#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "core/second_moments.h"
#include "denoise/every_target.h"
#include "denoise/make_denoiser.h"
#include "denoise/test_frames.h"

namespace stillray::keep_samples_test {
namespace {

using test::MakeDenoiser;
using test::OnEveryTarget;
using test::Random;
using test::SameBits;

constexpr int kWidth = 61;
constexpr int kHeight = 37;
constexpr int kBorder = 4;

TEST(KeepSamples, Formulas) {
  EXPECT_TRUE(KeepsSamples(1.0f, 2.0f));
  EXPECT_FALSE(KeepsSamples(1.0f, 1.0f));
  EXPECT_FALSE(KeepsSamples(0.0f, 4.0f));
  EXPECT_FLOAT_EQ(SampleNoise(6.0f, 4.0f, 4.0f), kKeptNoise * 2.0f);
  EXPECT_FLOAT_EQ(SampleNoise(0.0f, 4.0f, 4.0f), kKeptNoise * 1.0f);
  EXPECT_EQ(FilteredShare(2.0f, 3.0f), 1.0f);  // no more than noise
  EXPECT_EQ(FilteredShare(0.0f, 0.0f), 1.0f);
  EXPECT_FLOAT_EQ(FilteredShare(4.0f, 1.0f), 0.25f);
  EXPECT_EQ(FilteredShare(4.0f, 0.0f), 0.0f);
}

TEST(KeepSamples, DeviationsThatStickOutAreLimited) {
  EXPECT_FLOAT_EQ(ShareOfFiltered(4.0f, 1.0f, 2.0f, 0.5f), 0.25f);
  // 8 times the root of the noise, of 0.5 times the mean square: a quarter of it is kept.
  EXPECT_FLOAT_EQ(ShareOfFiltered(4.0f, 1.0f, 8.0f, 0.5f), 1.0f - 0.75f * 0.25f);
  EXPECT_FLOAT_EQ(ShareOfFiltered(4.0f, 1.0f, 8.0f, 0.0f), 0.25f);  // no limit
  EXPECT_EQ(ShareOfFiltered(4.0f, 0.0f, 1e9f, 0.5f), 0.0f);         // no noise
  EXPECT_EQ(ShareOfFiltered(1.0f, 1.0f, 8.0f, 0.5f), 1.0f);
  EXPECT_EQ(ReachOfEstimates(4), 0.5f);
  EXPECT_EQ(ReachOfEstimates(64), 2.0f);
}

/// The variance within a pixel has n - 1 degrees of freedom: in the mean, the noise is the margin
/// times the variance of the pixel.
TEST(KeepSamples, NoiseIsThatOfTheMeanOfAPixel) {
  constexpr int kTrials = 40000;
  for (const uint32_t n : {2u, 5u}) {
    double noise = 0;
    double square = 0;
    for (uint32_t i = 0; i < kTrials; ++i) {
      double sum = 0;
      double squares = 0;
      for (uint32_t k = 0; k < n; ++k) {
        const double sample = Random(i, k, n);  // variance 1/12
        sum += sample / n;
        squares += sample * sample / n;
      }
      noise += static_cast<double>(SampleNoise(static_cast<float>(squares - sum * sum), 0.0f,
                                               static_cast<float>(n))) /
               kTrials;
      square += (sum - 0.5) * (sum - 0.5) / kTrials;
    }
    EXPECT_NEAR(noise / square, static_cast<double>(kKeptNoise), 0.03) << n;
    EXPECT_NEAR(square, 1.0 / 12.0 / n, 0.03 / 12.0 / n);
  }
}

/// Planes of a wall with holes, missing pixels, and counts from 0 to 8.
struct StagePlanes {
  NewLight light = {LumaImage3(kWidth, kHeight), Image1(kWidth, kHeight), Image1(kWidth, kHeight)};
  LumaImage3 filtered{kWidth, kHeight};
  Image1 variance{kWidth, kHeight};
  Image1 inverse_depth{kWidth, kHeight};

  StagePlanes() {
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        const auto u = [&](uint32_t what) {
          return Random(static_cast<uint32_t>(x), static_cast<uint32_t>(y), what);
        };
        for (int c = 0; c < 3; ++c) {
          light.colour[c](x, y) = u(static_cast<uint32_t>(c));
          filtered[c](x, y) = 0.5f;
        }
        light.samples(x, y) = std::floor(9.0f * u(4));
        light.within(x, y) = 0.2f * u(5);
        variance(x, y) = 0.2f * u(6);
        inverse_depth(x, y) = u(7) < 0.05f ? 0.0f : 0.25f;
      }
    }
  }
  KeepSamplesInput Input() const { return {&light, &filtered, &variance, &inverse_depth}; }
};

void TestEveryTarget(float reach) {
  const StagePlanes planes;
  FilterPlanes expected(kWidth, kHeight, kBorder);
  Image1 expected_valid(kWidth, kHeight, kBorder);
  reference::MeasureSamples(planes.Input(), &expected, &expected_valid);
  LumaImage3 expected_light = planes.filtered;
  reference::KeepSamples(expected, expected_valid, planes.light, reach, &expected_light);
  ASSERT_FALSE(SameBits(expected_light, planes.filtered));
  OnEveryTarget([&] {
    FilterPlanes measured(kWidth, kHeight, kBorder);
    Image1 valid(kWidth, kHeight, kBorder);
    cpu::MeasureSamples(planes.Input(), &measured, &valid);
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        ASSERT_EQ(valid(x, y), expected_valid(x, y)) << x << " " << y;
        ASSERT_EQ(measured.colour[0](x, y), expected.colour[0](x, y)) << x << " " << y;
        ASSERT_EQ(measured.colour[1](x, y), expected.colour[1](x, y)) << x << " " << y;
        ASSERT_EQ(measured.variance(x, y), 0.0f) << x << " " << y;
      }
    }
    LumaImage3 light = planes.filtered;
    cpu::KeepSamples(measured, valid, planes.light, reach, &light);
    EXPECT_TRUE(SameBits(light, expected_light));
  });
}

TEST(KeepSamples, EveryTargetGivesTheBitsOfTheReference) {
  for (const float reach : {0.0f, 0.5f, 0.1f}) {
    TestEveryTarget(reach);
  }
}

/// Light on a wall: even on its left half, stripes on its right one, which move from frame to
/// frame.
float Truth(int x, int frame) {
  const bool dark = x >= kWidth / 2 && (x + 3 * frame) % 6 < 2;
  return dark ? 0.6f : 1.0f;
}

/// The wall with n exponentially distributed samples per pixel and their second moments.
Frame Wall(int index, int n) {
  Frame frame;
  frame.width = kWidth;
  frame.height = kHeight;
  frame.index = index;
  frame.guides.depth = Image1(kWidth, kHeight);
  frame.guides.depth.Fill(4);
  frame.guides.normal = Image3(kWidth, kHeight);
  frame.guides.normal[2].Fill(1);
  frame.guides.motion = Image2(kWidth, kHeight);
  frame.guides.albedo = Image3(kWidth, kHeight);
  frame.samples = Image1(kWidth, kHeight);
  frame.samples.Fill(static_cast<float>(n));
  Signal& light = frame.signals.emplace_back();
  light.kind = SignalKind::kDirectDiffuse;
  light.radiance = Image3(kWidth, kHeight);
  light.second_moment = Image1(kWidth, kHeight);
  for (int c = 0; c < 3; ++c) {
    frame.guides.albedo[c].Fill(1);
  }
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      double sum = 0;
      double squares = 0;
      for (int i = 0; i < n; ++i) {
        const float u = Random(static_cast<uint32_t>(x + kWidth * y), static_cast<uint32_t>(index),
                               static_cast<uint32_t>(i));
        const double sample = -std::log(1.0 - 0.999999 * static_cast<double>(u)) *
                              static_cast<double>(Truth(x, index));
        sum += sample / n;
        squares += sample * sample / n;
      }
      for (int c = 0; c < 3; ++c) {
        light.radiance[c](x, y) = static_cast<float>(sum);
      }
      light.second_moment(x, y) = static_cast<float>(squares);
    }
  }
  return frame;
}

/// Mean squared errors of the right half of the wall, and of the left one farther from it than the
/// levels of the stage see.
constexpr int kEvenWidth = kWidth / 2 - 8;
struct Errors {
  double even = 0;
  double stripes = 0;
};

Errors ErrorsOf(const Image3& colour, int frame) {
  Errors errors;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const double d = static_cast<double>(colour[1](x, y) - Truth(x, frame));
      if (x < kEvenWidth) {
        errors.even += d * d / (kHeight * kEvenWidth);
      } else if (x >= kWidth / 2) {
        errors.stripes += d * d / (kHeight * (kWidth - kWidth / 2));
      }
    }
  }
  return errors;
}

Image3 Denoised(int n, bool keep, int frames = 4) {
  Settings settings;
  settings.keep_samples = keep;
  Denoiser denoiser = MakeDenoiser(settings);
  DenoisedFrame out;
  for (int i = 1; i <= frames; ++i) {
    EXPECT_TRUE(denoiser.Denoise(Wall(i, n), &out).ok());
  }
  return out.colour;
}

TEST(KeepSamples, LightOfFineDetailIsNoWorseThanItsSamples) {
  for (const int n : {64, 256}) {
    const Errors noisy = ErrorsOf(Wall(4, n).signals.front().radiance, 4);
    const Errors off = ErrorsOf(Denoised(n, false), 4);
    const Errors on = ErrorsOf(Denoised(n, true), 4);
    EXPECT_LT(on.stripes, 1.15 * noisy.stripes) << n;
    EXPECT_LT(on.stripes, 0.8 * off.stripes) << n;
    EXPECT_LT(on.even, 0.2 * noisy.even) << n;
    EXPECT_LT(on.even, 1.1 * off.even) << n;
  }
}

TEST(KeepSamples, ConvergesToTheSamples) {
  const Errors few = ErrorsOf(Denoised(64, true), 4);
  const Errors many = ErrorsOf(Denoised(1024, true), 4);
  EXPECT_LT(many.stripes, few.stripes / 8);
}

/// How far the picture is from the truth at a pixel that has a rare bright sample.
float Speck(bool estimated) {
  constexpr int kX = 3 * kWidth / 4;
  constexpr int kY = kHeight / 2;
  Denoiser denoiser = MakeDenoiser({});
  DenoisedFrame out;
  for (int i = 1; i <= 4; ++i) {
    Frame frame = Wall(i, 16);
    for (int c = 0; c < 3 && i == 4; ++c) {
      frame.signals.front().radiance[c](kX, kY) += 3;
    }
    frame.signals.front().second_moment = Image1();
    EstimateSecondMoments(&frame);
    EXPECT_TRUE(frame.has_estimated_moments);
    frame.has_estimated_moments = estimated;
    EXPECT_TRUE(denoiser.Denoise(frame, &out).ok());
  }
  return out.colour[1](kX, kY) - Truth(kX, 4);
}

// Means hide the sample from the estimate of the noise.
TEST(KeepSamples, ARareBrightSampleIsNotKeptWhereNoiseIsAnEstimate) {
  EXPECT_GT(Speck(false), 0.3f);
  EXPECT_LT(Speck(true), 0.5f * Speck(false));
}

TEST(KeepSamples, OneSampleIsUnchanged) {
  EXPECT_TRUE(SameBits(Denoised(1, true), Denoised(1, false)));
}

}  // namespace
}  // namespace stillray::keep_samples_test
