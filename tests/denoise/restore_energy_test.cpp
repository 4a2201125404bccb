// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// restore_energy: the stage on computed planes, and the denoiser with it.
#include "denoise/stages/restore_energy.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>

#include <gtest/gtest.h>

#include "denoise/make_denoiser.h"
#include "denoise/stage_table.h"
#include "denoise/stages/prepare_guides.h"
#include "denoise/stages/select_guides_shared.h"
#include "denoise/test_frames.h"
#include "stage_planes.h"
#include "stage_test.h"

namespace stillray::restore_energy_test {
namespace {

using test::DefaultPlan;
using test::ForSizesAndTargets;
using test::MakeDenoiser;
using test::RandomAt;

using Formula = std::function<float(int x, int y)>;

/// Guides of surfaces that face the camera, at this depth.
GuidePlanes FacingGuides(int width, int height, const Formula& depth_at) {
  Image1 depth(width, height);
  Image3 normal(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      depth(x, y) = depth_at(x, y);
      normal[2](x, y) = 1;
    }
  }
  GuidePlanes guides(width, height, 16);
  guides.turn2 = Image1(width, height);
  cpu::PrepareGuides({&depth, &normal, nullptr}, &guides);
  return guides;
}

struct Light {
  Image1 accumulated, length;
  LumaImage3 filtered;

  /// Red and blue are 0.5 and 2 times the luminance.
  Light(int width, int height, const Formula& accumulated_at, const Formula& filtered_at)
      : accumulated(width, height), length(width, height), filtered(width, height, 1) {
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        accumulated(x, y) = accumulated_at(x, y);
        length(x, y) = 1;
        filtered[0](x, y) = filtered_at(x, y);
        filtered[1](x, y) = 0.5f * filtered[0](x, y);
        filtered[2](x, y) = 2 * filtered[0](x, y);
      }
    }
  }
};

/// The filtered light after the stage. \param roughness  see RestoredSignal
LumaImage3 Restored(const StageTable& stages, const GuidePlanes& guides, const Light& light,
                    const Image1* roughness = nullptr) {
  const int width = CoarseSize(light.length.width());
  const int height = CoarseSize(light.length.height());
  GuidePlanes coarse(width, height, kComparedBorder);
  ComparedPlanes compared(width, height);
  const EnergySignal measured = {&light.accumulated, &light.filtered[0], &light.length, &compared};
  stages.measure_energy({&measured, 1}, guides, &coarse);
  FilterPlanes* from = &compared.light;
  FilterPlanes* to = &compared.work;
  for (int level = 0; level < kCorrectHistoryLevels; ++level) {
    const AtrousSignal signal = {&from->colour, &from->variance, to, nullptr, &compared.valid};
    stages.atrous({&signal, 1}, coarse, ComparedLevel(level), DefaultPlan().compared);
    std::swap(from, to);
  }
  FindEnergyRatio(*from, &compared);
  LumaImage3 restored = light.filtered;
  const RestoredSignal signal = {&compared, &restored, roughness};
  stages.restore_energy({&signal, 1}, coarse, guides);
  return restored;
}

float Wall(int, int) {
  return 4;
}

TEST(RestoreEnergy, VersionsAgree) {
  ForSizesAndTargets([](int width, int height) {
    const GuidePlanes guides = FacingGuides(width, height, [](int x, int y) {
      const bool sky = RandomAt(x / 5, y / 3, 1) < 0.1f;
      return sky                                ? std::numeric_limits<float>::infinity()
             : RandomAt(x / 7, y / 5, 2) < 0.3f ? 9.0f
                                                : 4.0f;
    });
    Light light(
        width, height, [](int x, int y) { return 3 * RandomAt(x, y, 3); },
        [](int x, int y) { return RandomAt(x, y, 4); });
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        light.length(x, y) = RandomAt(x, y, 5) < 0.8f ? 2.0f : 0.0f;
      }
    }
    const LumaImage3 expected = Restored(kReferenceStages, guides, light);
    const LumaImage3 found = Restored(kCpuStages, guides, light);
    for (int c = 0; c < 3; ++c) {
      for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
          ASSERT_NEAR(found[c](x, y), expected[c](x, y), 2e-5f * (1 + expected[c](x, y)))
              << c << " " << x << " " << y;
        }
      }
    }
  });
}

TEST(RestoreEnergy, RightBrightnessKeepsItsBits) {
  const GuidePlanes guides = FacingGuides(40, 30, Wall);
  const auto level = [](int, int) { return 0.3f; };
  const Light light(40, 30, level, level);
  for (const StageTable* stages : {&kReferenceStages, &kCpuStages}) {
    const LumaImage3 restored = Restored(*stages, guides, light);
    for (int c = 0; c < 3; ++c) {
      EXPECT_EQ(test::DifferentBits(restored[c], light.filtered[c]), 0) << c;
    }
  }
}

// All weights of a wall that faces the camera are 1: in the middle of a large one the ratio follows
// from the means over blocks of 54x54 pixels.
TEST(RestoreEnergy, RatioOfAWallByHand) {
  constexpr int kSize = 120;
  const GuidePlanes guides = FacingGuides(kSize, kSize, Wall);
  // Each block of 2x2 pixels has the mean 1 + 0.5 or 1 - 0.5, in turn.
  const auto accumulated = [](int x, int y) { return (x / 2 + y / 2) % 2 == 0 ? 1.5f : 0.5f; };
  const auto filtered = [](int, int) { return 0.8f; };
  const Light light(kSize, kSize, accumulated, filtered);
  double a = 0;
  double noise = 0;
  const int centre = kSize / 4;  // in blocks
  for (int by = centre - 13; by <= centre + 13; ++by) {
    for (int bx = centre - 13; bx <= centre + 13; ++bx) {
      const double mean = (bx + by) % 2 == 0 ? 1.5 : 0.5;
      a += mean / 729;
      noise += (mean - 0.8) * (mean - 0.8) / (729.0 * 729);
    }
  }
  const double d = a - 0.8;
  const double expected = 1 + std::max(0.0, 1 - noise / (d * d)) * d / 0.8;
  ASSERT_GT(expected, 1.2);
  for (const StageTable* stages : {&kReferenceStages, &kCpuStages}) {
    const LumaImage3 restored = Restored(*stages, guides, light);
    // The neighbouring blocks differ by one in 729 in the sign of one block: 0.2 %.
    EXPECT_NEAR(restored[0](2 * centre, 2 * centre) / 0.8, expected, 0.003);
    EXPECT_NEAR(restored[1](2 * centre, 2 * centre) / 0.4, expected, 0.003);
    EXPECT_NEAR(restored[2](2 * centre, 2 * centre) / 1.6, expected, 0.003);
  }
}

TEST(RestoreEnergy, OnlyPixelsWithGuidesOfImagesChangeInReflectedLight) {
  const GuidePlanes guides = FacingGuides(70, 50, Wall);
  const Light light(
      70, 50, [](int, int) { return 0.5f; }, [](int, int) { return 0.4f; });
  Image1 roughness(70, 50);
  for (int y = 0; y < 50; ++y) {
    for (int x = 0; x < 70; ++x) {
      roughness(x, y) = x % 3 == 0 ? kRoughnessOfImage : x % 3 == 1 ? 0.05f : 1.0f;
    }
  }
  for (const StageTable* stages : {&kReferenceStages, &kCpuStages}) {
    const LumaImage3 all = Restored(*stages, guides, light);
    const LumaImage3 some = Restored(*stages, guides, light, &roughness);
    for (int y = 0; y < 50; ++y) {
      for (int x = 0; x < 70; ++x) {
        EXPECT_GT(all[0](x, y), 0.45f);
        EXPECT_EQ(some[0](x, y), x % 3 == 0 ? all[0](x, y) : 0.4f) << x << " " << y;
      }
    }
  }
}

TEST(RestoreEnergy, NothingLeaksOverAnEdge) {
  const GuidePlanes guides = FacingGuides(80, 40, [](int x, int) { return x < 40 ? 4.0f : 6.0f; });
  const Light light(
      80, 40, [](int x, int) { return x < 40 ? 1.0f : 2.0f; }, [](int, int) { return 1.0f; });
  const LumaImage3 restored = Restored(kCpuStages, guides, light);
  for (int y = 0; y < 40; ++y) {
    for (int x = 0; x < 80; ++x) {
      // Blocks at the picture's edges average fewer blocks, so their noise is higher.
      ASSERT_NEAR(restored[0](x, y), x < 40 ? 1.0f : 2.0f, x < 40 ? 1e-5f : 0.12f) << x << " " << y;
    }
  }
}

TEST(RestoreEnergy, ASingleBrightSampleIsNoise) {
  const GuidePlanes guides = FacingGuides(60, 60, Wall);
  const Light light(
      60, 60, [](int x, int y) { return x == 31 && y == 29 ? 5000.0f : 1.0f; },
      [](int, int) { return 1.0f; });
  const LumaImage3 restored = Restored(kCpuStages, guides, light);
  for (int y = 0; y < 60; ++y) {
    for (int x = 0; x < 60; ++x) {
      ASSERT_NEAR(restored[0](x, y), 1.0f, 1e-4f) << x << " " << y;
    }
  }
}

TEST(RestoreEnergy, NoiseChangesLittle) {
  constexpr int kSize = 120;
  const GuidePlanes guides = FacingGuides(kSize, kSize, Wall);
  const Light light(
      kSize, kSize, [](int x, int y) { return -std::log(1 - RandomAt(x, y, 7)); },
      [](int, int) { return 1.0f; });
  const LumaImage3 restored = Restored(kCpuStages, guides, light);
  double square = 0;
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x) {
      square += (restored[0](x, y) - 1) * (restored[0](x, y) - 1) / (kSize * kSize);
    }
  }
  // The means over 54x54 pixels deviate by 1/54; at the edges of the picture by up to twice that.
  EXPECT_LT(std::sqrt(square), 1.0 / 54);
}

/// A wall with sparse indirect light: one sample in ten is 1.
Frame SparseFrame(int index) {
  Frame frame = test::MakeWall(128, 96, index);
  test::FillImage<3>(&test::Light(&frame, SignalKind::kIndirectDiffuse), [&](int x, int y, int) {
    return RandomAt(x, y, 100 + static_cast<uint32_t>(index)) < 0.1f ? 1.0f : 0.0f;
  });
  return frame;
}

/// Mean of the fourth picture of sparse light, over the mean of all samples, with the published
/// luminance weights, which refuse most of it.
double BrightnessOfSparseLight(bool restore_energy) {
  Settings settings;
  settings.pilot = false;
  settings.noise_ratio = 1;
  settings.sigma_l = 1;
  settings.restore_energy = restore_energy;
  Denoiser denoiser = MakeDenoiser(settings);
  DenoisedFrame out;
  double samples = 0;
  for (int i = 0; i < 4; ++i) {
    Frame frame = SparseFrame(i);
    samples += test::MeanOf(test::Light(&frame, SignalKind::kIndirectDiffuse)) / 4;
    EXPECT_TRUE(denoiser.Denoise(frame, &out).ok());
  }
  return test::MeanOf(out.colour) / samples;
}

TEST(RestoreEnergy, SparseLightKeepsItsBrightness) {
  EXPECT_NEAR(BrightnessOfSparseLight(true), 1, 0.02);
  EXPECT_LT(BrightnessOfSparseLight(false), 0.9);
}

}  // namespace
}  // namespace stillray::restore_energy_test
