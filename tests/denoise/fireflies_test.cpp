// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Limits on single bright samples: their effect on light and on fireflies.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "denoise/make_denoiser.h"
#include "denoise/test_frames.h"

namespace stillray::fireflies_test {
namespace {

using test::MakeDenoiser;

constexpr int kSize = 64;
constexpr int kFrames = 8;

/// Samples of light of mean 1, from a uniform number.
using Noise = float (*)(float u);

float Exponential(float u) {
  return -std::log(std::max(1 - u, 1e-7f));
}
float Sparse(float u) {
  return u < 0.1f ? 10.0f : 0.0f;
}
/// Of a logarithm with deviation 1: the heaviest tail of light without fireflies. Box and Muller's
/// formula with a golden-ratio partner of u.
float LogNormal(float u) {
  const float v = u * 1000.618f - std::floor(u * 1000.618f);
  const float normal = std::sqrt(-2 * std::log(std::max(u, 1e-7f))) * std::cos(6.2831853f * v);
  return std::exp(normal - 0.5f);
}

Frame NoisyWall(Noise noise, float unit, int64_t index) {
  Frame f = test::MakeWall(kSize, kSize, index);
  test::FillImage<3>(&test::Light(&f, SignalKind::kDirectDiffuse), [&](int x, int y, int) {
    const auto pixel = static_cast<uint32_t>(y * kSize + x);
    return unit * noise(test::Random(static_cast<uint32_t>(index), pixel, 31));
  });
  return f;
}

Settings WithFirefly(const char* preset, const char* value) {
  Settings s = PresetSettings(preset).value();
  EXPECT_TRUE(SetParameter(&s, "firefly", value).ok());
  return s;
}

double Brightness(const Settings& settings, Noise noise, float unit, Backend backend) {
  Denoiser d = MakeDenoiser(settings, backend);
  DenoisedFrame out;
  for (int i = 0; i < kFrames; ++i) {
    EXPECT_TRUE(d.Denoise(NoisyWall(noise, unit, i), &out).ok());
  }
  return test::MeanOf(out.colour) / static_cast<double>(unit);
}

TEST(Fireflies, CompressKeepsTheMeanOfNoisyLight) {
  for (const char* preset : {"svgf", "default"}) {
    for (const Noise noise : {Exponential, Sparse, LogNormal}) {
      const double off = Brightness(WithFirefly(preset, "off"), noise, 1, Backend::kCpu);
      for (const float unit : {1e-4f, 0.2f, 1.0f}) {
        const Settings s = WithFirefly(preset, "compress");
        const double on = Brightness(s, noise, unit, Backend::kCpu);
        EXPECT_NEAR(on / off, 1, 0.02) << preset << " in units of " << unit;
        if (unit == 1 && noise == Sparse) {  // slow, most of all under sanitizers
          EXPECT_NEAR(Brightness(s, noise, unit, Backend::kReference) / on, 1, 1e-3);
        }
      }
    }
  }
}

/// The part of the light that remains under means in time, which are linear.
double Kept(const char* firefly, Noise noise, float unit) {
  const auto brightness = [&](const char* value) {
    Settings s = WithFirefly("svgf", value);
    s.wavelet = Wavelet::kOff;
    return Brightness(s, noise, unit, Backend::kCpu);
  };
  return brightness(firefly) / brightness("off");
}

// The losses that docs/denoiser.md names. A sample that is clamped to the brightest of eight others
// of an exponential distribution of mean 1 loses 1/9, the integral of u^8 over 0..1. Of light in a
// tenth of the pixels, that without a lit neighbour is lost.
TEST(Fireflies, ClampLosesLightInAnyUnit) {
  for (const float unit : {0.01f, 1.0f, 16.0f}) {
    EXPECT_NEAR(Kept("clamp", Exponential, unit), 8.0 / 9, 0.02) << unit;
    EXPECT_NEAR(Kept("clamp", Sparse, unit), 1 - std::pow(0.9, 8), 0.03) << unit;
  }
}

// Means of few lit samples stay below the knee, where the curve is the identity: what is left is
// the value of a sample under the curve in proportion to its own.
TEST(Fireflies, CompressLosesLightBeyondItsKnee) {
  constexpr float kAlbedo = 0.5f;  // of the wall, which divides the light
  const double sample = 160;
  const double under_curve = 64 - 32 * 32 / sample;
  EXPECT_NEAR(Kept("compress", Sparse, 16 * kAlbedo), under_curve / sample, 0.01);
  EXPECT_NEAR(Kept("compress", Sparse, 3 * kAlbedo), 1, 1e-3);  // samples of 30
}

/// The brightest pixel of the last frame, in which one sample is a firefly.
double PeakBesideFirefly(const char* firefly) {
  Denoiser d = MakeDenoiser(WithFirefly("svgf", firefly));
  DenoisedFrame out;
  for (int i = 0; i < kFrames; ++i) {
    Frame f = NoisyWall(Exponential, 1, i);
    if (i == kFrames - 1) {
      for (int c = 0; c < 3; ++c) {
        test::Light(&f, SignalKind::kDirectDiffuse)[c](30, 30) = 1e7f;
      }
    }
    EXPECT_TRUE(d.Denoise(f, &out).ok());
  }
  double peak = 0;
  for (int y = 0; y < kSize; ++y) {
    peak = std::max<double>(peak,
                            *std::max_element(out.colour[1].Row(y), out.colour[1].Row(y) + kSize));
  }
  return peak;
}

TEST(Fireflies, CompressLimitsWhatOneSampleCounts) {
  const double off = PeakBesideFirefly("off");
  const double compressed = PeakBesideFirefly("compress");
  EXPECT_GT(off, 50);
  EXPECT_LT(compressed, off / 50);
}

TEST(Fireflies, CompressLeavesBrightLightWithoutNoiseAsItIs) {
  // A lamp's reflection, far beyond the knee.
  Settings s = WithFirefly("svgf", "compress");
  s.wavelet = Wavelet::kOff;
  Denoiser d = MakeDenoiser(s);
  DenoisedFrame out;
  for (int i = 0; i < kFrames; ++i) {
    Frame f = test::MakeWall(kSize, kSize, i);
    test::FillImage<3>(&test::Light(&f, SignalKind::kDirectDiffuse),
                       [&](int x, int y, int) { return x < 4 && y < 4 ? 2000.0f : 1.0f; });
    ASSERT_TRUE(d.Denoise(f, &out).ok());
    EXPECT_NEAR(out.colour[0](0, 0), 2000, 20);
    EXPECT_NEAR(out.colour[0](40, 40), 1, 0.01);
  }
}

}  // namespace
}  // namespace stillray::fireflies_test
