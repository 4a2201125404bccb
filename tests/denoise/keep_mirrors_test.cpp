// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// keep_mirrors: the stage on computed planes, and the denoiser on a scene with a chrome ball.
#include "denoise/stages/keep_mirrors.h"

#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "denoise/every_target.h"
#include "denoise/make_denoiser.h"
#include "denoise/mirror_scene.h"
#include "denoise/stages/keep_mirrors_shared.h"
#include "denoise/stages/keep_samples.h"

namespace stillray::keep_mirrors_test {
namespace {

using test::MakeDenoiser;
using test::MirrorScene;
using test::OnEveryTarget;
using test::Random;
using test::RegionPsnr;
using test::SameBits;

constexpr int kWidth = 43;
constexpr int kHeight = 29;
constexpr int kBorder = 4;

TEST(KeepMirrors, Formulas) {
  EXPECT_TRUE(IsMirror(1.0f, 1.0f, 0.1f, 0.1f));
  EXPECT_FALSE(IsMirror(1.0f, 1.0f, 0.11f, 0.1f));
  EXPECT_FALSE(IsMirror(0.0f, 1.0f, 0.0f, 0.1f));
  EXPECT_FALSE(IsMirror(1.0f, 0.0f, 0.0f, 0.1f));
  EXPECT_FALSE(IsMirror(1.0f, 1.0f, -0.1f, 0.1f));
  EXPECT_FALSE(IsMirror(1.0f, 1.0f, std::nanf(""), 0.1f));
  EXPECT_FLOAT_EQ(NoiseOfNearest(1.0f, 3.0f, 1.5f), 3.0f);
  EXPECT_EQ(NoiseOfNearest(1.0f, kNoNeighbour, 1.5f), 0.0f);  // one neighbour says nothing
}

/// The estimate of normal noise is a little below its variance, that of rare bright samples above
/// it.
TEST(KeepMirrors, NoiseIsMeasuredWithinTheFrame) {
  const auto estimate = [](float rare) {
    double sum = 0;
    double square = 0;
    double mean = 0;
    constexpr int kTrials = 20000;
    for (uint32_t i = 0; i < kTrials; ++i) {
      float sample[9];
      for (uint32_t k = 0; k < 9; ++k) {
        const float u = std::max(Random(i, k, 1), 1e-6f);
        const float normal = std::sqrt(-2 * std::log(u)) * std::cos(6.2831853f * Random(i, k, 2));
        sample[k] = rare > 0 ? (u < rare ? 1.0f : 0.0f) : normal;
        mean += static_cast<double>(sample[k]) / (9 * kTrials);
        square += static_cast<double>(sample[k] * sample[k]) / (9 * kTrials);
      }
      float first = kNoNeighbour;
      float second = kNoNeighbour;
      for (int k = 1; k < 9; ++k) {
        const float d = sample[0] - sample[k];
        second = std::min(second, std::max(first, d * d));
        first = std::min(first, d * d);
      }
      sum += static_cast<double>(NoiseOfNearest(first, second, kNearestNoise)) / kTrials;
    }
    return sum / (square - mean * mean);
  };
  EXPECT_NEAR(estimate(0), 0.845, 0.06);
  EXPECT_NEAR(estimate(0.05f), 2.55, 0.3);
}

/// Planes of a wall, half of it a mirror, with broken and missing pixels.
struct Planes {
  NewLight light = {LumaImage3(kWidth, kHeight), Image1(kWidth, kHeight), Image1()};
  LumaImage3 filtered{kWidth, kHeight};
  GuidePlanes guides = GuidePlanes(kWidth, kHeight, kBorder);
  Image1 roughness = Image1(kWidth, kHeight);
  Image2 motion = Image2(kWidth, kHeight);

  Planes() {
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        const auto u = [&](uint32_t what) {
          return Random(static_cast<uint32_t>(x), static_cast<uint32_t>(y), what);
        };
        for (int c = 0; c < 3; ++c) {
          light.colour[c](x, y) = u(static_cast<uint32_t>(c));
          filtered[c](x, y) = 0.5f;
        }
        light.samples(x, y) = u(4) < 0.1f ? 0.0f : 1.0f;
        guides.inverse_depth(x, y) = u(5) < 0.05f ? 0.0f : 0.25f;
        guides.normal[2](x, y) = 1;
        roughness(x, y) = u(6) < 0.05f ? std::nanf("") : x < 20 ? 0.05f : 0.3f;
        motion[0](x, y) = y < 14 ? 0.0f : 2.0f;
      }
    }
  }
  KeepMirrorsInput Input(bool with_motion) const {
    return {&light, &filtered, &guides, &roughness, with_motion ? &motion : nullptr};
  }
};

constexpr KeepMirrorsParameters kParameters = {.mirror_roughness = 0.1f, .mirror_signals = 1};

TEST(KeepMirrors, EveryTargetGivesTheBitsOfTheReference) {
  const Planes planes;
  for (const bool with_motion : {false, true}) {
    FilterPlanes expected(kWidth, kHeight, kBorder);
    Image1 expected_valid(kWidth, kHeight, kBorder);
    reference::MeasureMirrors(planes.Input(with_motion), kParameters, &expected, &expected_valid);
    LumaImage3 expected_light = planes.filtered;
    reference::KeepSamples(expected, expected_valid, planes.light, 0, &expected_light);
    ASSERT_FALSE(SameBits(expected_light, planes.filtered));
    OnEveryTarget([&] {
      FilterPlanes measured(kWidth, kHeight, kBorder);
      Image1 valid(kWidth, kHeight, kBorder);
      cpu::MeasureMirrors(planes.Input(with_motion), kParameters, &measured, &valid);
      for (int y = 0; y < kHeight; ++y) {
        for (int x = 0; x < kWidth; ++x) {
          ASSERT_EQ(valid(x, y), expected_valid(x, y)) << x << " " << y;
          for (int c = 0; c < 2 && valid(x, y) > 0; ++c) {
            ASSERT_EQ(measured.colour[c](x, y), expected.colour[c](x, y)) << x << " " << y;
          }
        }
      }
      LumaImage3 light = planes.filtered;
      cpu::KeepSamples(expected, valid, planes.light, 0, &light);
      EXPECT_TRUE(SameBits(light, expected_light));
    });
  }
}

/// The denoised frame of the scene, after the frames before it.
Image3 Denoised(const MirrorScene& scene, Settings settings, int frames) {
  Denoiser denoiser = MakeDenoiser(settings);
  DenoisedFrame out;
  for (int i = 1; i <= frames; ++i) {
    EXPECT_TRUE(denoiser.Denoise(scene.Trace(i), &out).ok());
  }
  return out.colour;
}

struct Measured {
  double noisy;
  double before;  ///< without the stage
  double after;
};

/// The chrome ball after some frames; nothing else in the picture may change.
Measured MeasureChrome(const MirrorScene& scene, int frames = 8) {
  constexpr int kSamples = 64;
  const Frame noisy = scene.Trace(frames);
  const Image3 reference = SumOfLight(scene.Trace(frames, kSamples));
  Settings off;
  off.mirror_roughness = 0;
  const Image3 before = Denoised(scene, off, frames);
  const Image3 after = Denoised(scene, Settings(), frames);
  const Plane<uint32_t>& ids = noisy.guides.id;
  for (int y = 0; y < before.height(); ++y) {
    for (int x = 0; x < before.width(); ++x) {
      if (ids(x, y) != MirrorScene::kChrome) {
        EXPECT_EQ(before[1](x, y), after[1](x, y)) << x << " " << y;
      }
    }
  }
  return {RegionPsnr(SumOfLight(noisy), reference, ids, MirrorScene::kChrome),
          RegionPsnr(before, reference, ids, MirrorScene::kChrome),
          RegionPsnr(after, reference, ids, MirrorScene::kChrome)};
}

TEST(KeepMirrors, AMovingMirrorIsNoWorseThanItsSamples) {
  const Measured chrome = MeasureChrome(MirrorScene(240, 135, 1.0f));
  EXPECT_LT(chrome.before, chrome.noisy - 2);  // the problem that the stage solves
  EXPECT_GT(chrome.after, chrome.noisy - 0.5);
  EXPECT_GT(chrome.after, chrome.before + 3);
}

TEST(KeepMirrors, AStillMirrorIsAsCleanAsEver) {
  const Measured chrome = MeasureChrome(MirrorScene(160, 90, 0.0f), 12);
  EXPECT_GT(chrome.before, chrome.noisy + 3);
  EXPECT_GT(chrome.after, chrome.before - 0.5);
}

TEST(KeepMirrors, NoiseInAMirrorIsFiltered) {
  // Of sixteen points one looks at the sky.
  MirrorScene scene(160, 90, 1.0f);
  scene.sky_one_of = 16;
  const Measured chrome = MeasureChrome(scene);
  EXPECT_GT(chrome.after, chrome.before - 0.3);
  EXPECT_GT(chrome.after, chrome.noisy - 0.3);
}

TEST(KeepMirrors, RoughnessDecides) {
  MirrorScene scene(96, 54, 1.0f);
  const auto picture = [&](float limit, bool with_roughness) {
    Settings settings;
    settings.mirror_roughness = limit;
    Denoiser denoiser = MakeDenoiser(settings);
    DenoisedFrame out;
    for (int i = 1; i <= 3; ++i) {
      Frame f = scene.Trace(i);
      if (!with_roughness) {
        f.guides.roughness = Image1();
      }
      EXPECT_TRUE(denoiser.Denoise(f, &out).ok());
    }
    return out.colour;
  };
  scene.chrome_roughness = 0.05f;
  const Image3 off = picture(0, true);
  EXPECT_TRUE(SameBits(picture(0.04f, true), off));  // nothing is that smooth
  EXPECT_TRUE(SameBits(picture(0.1f, false), off));  // none is given
  EXPECT_FALSE(SameBits(picture(0.1f, true), off));
}

TEST(KeepMirrors, LeavesTheHistoryAlone) {
  // With feedback of the last level the finished light is the history.
  const MirrorScene scene(64, 36, 1.0f);
  for (const int feedback : {0, 5}) {
    const auto history = [&](float limit) {
      Settings settings;
      settings.feedback = feedback;
      settings.mirror_roughness = limit;
      Denoiser denoiser = MakeDenoiser(settings);
      DenoisedFrame out;
      for (int i = 1; i <= 3; ++i) {
        EXPECT_TRUE(denoiser.SetOutputs({"accumulated.specular"}).ok());
        EXPECT_TRUE(denoiser.Denoise(scene.Trace(i), &out).ok());
      }
      const NamedImage& image = out.images.front();
      Image3 copy(64, 36);
      for (int c = 0; c < 3; ++c) {
        copy[c] = image.channels[static_cast<size_t>(c)];
      }
      return std::pair(std::move(copy), std::move(out.colour));
    };
    const auto [off, off_colour] = history(0);
    const auto [on, on_colour] = history(0.1f);
    EXPECT_TRUE(SameBits(on, off)) << feedback;
    EXPECT_FALSE(SameBits(on_colour, off_colour)) << feedback;
  }
}

}  // namespace
}  // namespace stillray::keep_mirrors_test
