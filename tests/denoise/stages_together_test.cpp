// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Stages that run together, row by row, must leave the very bits of one after the other.
#include <cmath>

#include <vector>

#include <gtest/gtest.h>

#include "denoise/cpu/fused/fused.h"
#include "denoise/stages/antialias.h"
#include "denoise/stages/prepare_guides.h"
#include "denoise/stages/reproject.h"
#include "every_target.h"
#include "stage_planes.h"

namespace stillray::stages_together_test {
namespace {

using test::DifferentBits;
using test::kHeight;
using test::kWidth;
using test::OnEveryTarget;

template <typename Image = Image3>
Image RandomImage(uint32_t seed) {
  Image image(kWidth, kHeight);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      for (int c = 0; c < 3; ++c) {
        image[c](x, y) = 2 * test::Random(x, y, seed + static_cast<uint32_t>(c));
      }
    }
  }
  return image;
}

/// Motion by a fraction of a pixel, but for a corner in which every pixel goes its own way, the
/// middle, which stands still, and columns at the bottom that move against each other.
Image2 MakeMotion() {
  constexpr float kMotion[3][2] = {{1.3f, -0.6f}, {-3.2f, 1.4f}, {0.7f, -2.1f}};
  Image2 motion(kWidth, kHeight);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const bool wild = x < 20 && y < 10;
      const bool still = y > 15 && y < 25;
      const int column = y > 26 ? x / 11 % 3 : 0;
      motion[0](x, y) = still ? 0.0f : wild ? 9 * test::Random(x, y, 40) - 4 : kMotion[column][0];
      motion[1](x, y) = still ? 0.0f : wild ? 9 * test::Random(x, y, 41) - 4 : kMotion[column][1];
    }
  }
  return motion;
}

TEST(StagesTogether, PrepareAndFindTaps) {
  Image1 depth(kWidth, kHeight);
  Image3 normal = RandomImage(50);
  Plane<uint32_t> id(kWidth, kHeight);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      depth(x, y) = 2 + 0.01f * static_cast<float>(x) + 0.02f * static_cast<float>(y);
      normal[2](x, y) += 3;
      id(x, y) = 1 + static_cast<uint32_t>(x / 30);
    }
  }
  depth(7, 0) = std::nanf("");
  depth(kWidth - 1, kHeight - 1) = -1;
  normal[1](40, 20) = HUGE_VALF;
  const PrepareGuidesInput in = {&depth, &normal, &id};
  const Image2 motion = MakeMotion();
  const auto compare = [&](bool packs_normals) {
    GuidePlanes before(kWidth, kHeight, 4, packs_normals);
    cpu::PrepareGuides(in, &before);
    GuidePlanes apart(kWidth, kHeight, 4, packs_normals);
    ReprojectionTaps taps_apart(kWidth, kHeight);
    EXPECT_EQ(cpu::PrepareGuides(in, &apart), 3);
    cpu::FindTaps(apart, before, motion, test::DefaultPlan().reproject, &taps_apart);
    GuidePlanes together(kWidth, kHeight, 4, packs_normals);
    ReprojectionTaps taps(kWidth, kHeight);
    EXPECT_EQ(cpu::PrepareAndFindTaps(in, before, motion, test::DefaultPlan().reproject, &together,
                                      &taps),
              3);
    EXPECT_EQ(DifferentBits(together.inverse_depth, apart.inverse_depth), 0);
    EXPECT_EQ(DifferentBits(together.depth, apart.depth), 0);
    if (packs_normals) {
      EXPECT_EQ(DifferentBits(together.packed_normal, apart.packed_normal), 0);
    } else {
      EXPECT_EQ(DifferentBits(together.normal, apart.normal), 0);
    }
    EXPECT_EQ(DifferentBits(together.gradient, apart.gradient), 0);
    EXPECT_EQ(DifferentBits(together.id, apart.id), 0);
    EXPECT_EQ(taps.patterns, taps_apart.patterns);
    EXPECT_EQ(taps.gathers, taps_apart.gathers);
    EXPECT_EQ(taps.scattered, taps_apart.scattered);
    EXPECT_EQ(DifferentBits(taps.weight, taps_apart.weight), 0);
    EXPECT_EQ(DifferentBits(taps.x, taps_apart.x), 0);
    EXPECT_EQ(DifferentBits(taps.search, taps_apart.search), 0);
  };
  OnEveryTarget([&] {
    compare(false);
    compare(true);
  });
}

TEST(StagesTogether, TapsSideBySideAreToldPerVector) {
  const GuidePlanes guides = test::MakeGuides(false);
  const SignalHistory history = test::MakeHistory(false);
  const Image2 motion = MakeMotion();
  ReprojectionTaps expected_taps(kWidth, kHeight);
  reference::FindTaps(guides, guides, motion, test::DefaultPlan().reproject, &expected_taps);
  SignalHistory expected = history;
  reference::FetchHistory(history, expected_taps, &expected);
  OnEveryTarget([&] {
    ReprojectionTaps taps(kWidth, kHeight);
    cpu::FindTaps(guides, guides, motion, test::DefaultPlan().reproject, &taps);
    int blocks = 0;
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        EXPECT_EQ(taps.HasHistory(x, y), expected_taps.HasHistory(x, y)) << x << ", " << y;
        blocks += taps.PatternOf(x, y) == TapPattern::kBlock2x2 ? 1 : 0;
      }
    }
    EXPECT_GT(blocks, 0);
    SignalHistory fetched = history;
    cpu::FetchHistory(history, taps, &fetched);
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        for (int c = 0; c < 3; ++c) {
          EXPECT_NEAR(fetched.colour[c](x, y), expected.colour[c](x, y), 1e-4) << x << ", " << y;
        }
        EXPECT_NEAR(fetched.length(x, y), expected.length(x, y), 1e-4) << x << ", " << y;
      }
    }
  });
}

/// Albedos of this frame and the last one, and lengths of light, some of them short.
struct Texture {
  Texture()
      : albedo(kWidth, kHeight),
        before(RandomImage(150)),
        length(kWidth, kHeight, 3),
        depth_before(kWidth, kHeight) {
    const Image3 parts[2] = {RandomImage(140), RandomImage(160)};
    const Image3* const albedos[2] = {&parts[0], &parts[1]};
    Image1 images(kWidth, kHeight);
    for (int y = 0; y < kHeight; ++y) {
      std::fill_n(images.Row(y) + kWidth / 2, kWidth / 4, 5.0f);  // with edges in the picture
    }
    reference::SumAlbedo(albedos, &images, &albedo);
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        length(x, y) = static_cast<float>((x / 3 + y) % 9);
        depth_before(x, y) = (x / 11 + y / 7) % 2 == 0 ? 0.2f : 0.25f;
      }
    }
  }

  SummedAlbedo albedo;
  Image3 before;
  Image1 length;
  Image1 depth_before;  ///< edges of both surfaces in places
};

/// Each filter that resamples the last image, with and without extrapolated motion.
std::vector<AntialiasParameters> EveryResampling() {
  std::vector<AntialiasParameters> all;
  for (const int resampling : {kCatmullRom, kSpline, kSubcell}) {
    for (const int extrapolate : {0, 1}) {
      all.push_back(test::DefaultPlan().antialias);
      all.back().resampling = resampling;
      all.back().extrapolate_motion = extrapolate;
    }
  }
  return all;
}

// In vectors of one motion, of several, and of as many as pixels.
TEST(Antialias, FollowsAnyMotion) {
  const GuidePlanes guides = test::MakeGuides(true);
  const Image2 motion = MakeMotion();
  const Image3 previous = RandomImage(120);
  Image3 colour(kWidth, kHeight);  // so that the clamp lets everything pass
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      for (int c = 0; c < 3; ++c) {
        colour[c](x, y) = (x + y) % 2 == 0 ? -1.0f : 3.0f;
      }
    }
  }
  const Image3 coefficients = RandomImage(130);
  for (const AntialiasParameters& p : EveryResampling()) {
    const Image3* const spline = p.resampling == kSpline ? &coefficients : nullptr;
    const AntialiasInput in = {previous, motion, guides, spline};
    Image3 expected(kWidth, kHeight);
    reference::Antialias(colour, in, p, &expected);
    OnEveryTarget([&] {
      Image3 found(kWidth, kHeight);
      cpu::Antialias(colour, in, p, &found);
      for (int y = 0; y < kHeight; ++y) {
        for (int x = 0; x < kWidth; ++x) {
          for (int c = 0; c < 3; ++c) {
            EXPECT_NEAR(found[c](x, y), expected[c](x, y), 1e-4) << x << ", " << y;
          }
        }
      }
    });
  }
}

TEST(Antialias, ClampsTheLightOfAnyMotion) {
  const GuidePlanes guides = test::MakeGuides(true);
  const Image2 motion = MakeMotion();
  const Image3 previous = RandomImage(120);
  const Image3 colour = RandomImage(170);
  const Image3 coefficients = RandomImage(130);
  const Texture texture;
  for (const AntialiasParameters& p : EveryResampling()) {
    const Image3* const spline = p.resampling == kSpline ? &coefficients : nullptr;
    for (const Image3* before : {&texture.before, static_cast<const Image3*>(nullptr)}) {
      AntialiasInput in = {previous, motion, guides, spline};
      in.length = &texture.length;
      Image3 expected_albedo(kWidth, kHeight);
      AntialiasTexture of = {texture.albedo, before, spline, &expected_albedo,
                             &texture.depth_before};
      in.texture = &of;
      Image3 expected(kWidth, kHeight);
      reference::Antialias(colour, in, p, &expected);
      OnEveryTarget([&] {
        Image3 found(kWidth, kHeight);
        Image3 found_albedo(kWidth, kHeight);
        of.out = &found_albedo;
        cpu::Antialias(colour, in, p, &found);
        test::ExpectNear(found, expected, 1e-4, 1e-4);
        test::ExpectNear(found_albedo, expected_albedo, 1e-4, 1e-4);
      });
    }
  }
}

TEST(StagesTogether, AntialiasParts) {
  const GuidePlanes guides = test::MakeGuides(true);
  const LumaImage3 lights[2] = {RandomImage<LumaImage3>(80), RandomImage<LumaImage3>(90)};
  const Image3 albedo = RandomImage(100);
  Image3 emission = RandomImage(110);
  emission[1](82, 0) = HUGE_VALF;
  emission[0](0, 24) = std::nanf("");  // where one band ends and the next begins
  const Image3 previous = RandomImage(120);
  const Image2 motion = MakeMotion();
  SignalLight signals[2] = {{&lights[0], {}}, {&lights[1], {}}};
  signals[0].albedo.part[signals[0].albedo.count++] = &albedo;
  const Image3* const unfiltered[1] = {&emission};
  OnEveryTarget([&] {
    const PictureParts parts = {signals, unfiltered, {false, /*add=*/false}};
    Image3 picture(kWidth, kHeight);
    EXPECT_EQ(cpu::Remodulate(signals, unfiltered, parts.remodulate, &picture), 2);
    Image3 apart(kWidth, kHeight);
    const AntialiasParameters& p = test::DefaultPlan().antialias;
    AntialiasInput input = {previous, motion, guides};
    cpu::Antialias(picture, input, p, &apart);
    Image3 together(kWidth, kHeight);
    Image3 copy(kWidth, kHeight);
    input.copy = &copy;
    EXPECT_EQ(cpu::AntialiasParts(parts, input, p, &together), 2);
    EXPECT_EQ(DifferentBits(together, apart), 0);
    EXPECT_EQ(DifferentBits(copy, apart), 0);
    const Texture texture;
    Image3 albedo_apart(kWidth, kHeight);
    Image3 albedo_together(kWidth, kHeight);
    AntialiasTexture of = {texture.albedo, &texture.before, nullptr, &albedo_apart,
                           &texture.depth_before};
    input.length = &texture.length;
    input.texture = &of;
    cpu::Antialias(picture, input, p, &apart);
    of.out = &albedo_together;
    EXPECT_EQ(cpu::AntialiasParts(parts, input, p, &together), 2);
    EXPECT_EQ(DifferentBits(together, apart), 0);
    EXPECT_EQ(DifferentBits(albedo_together, albedo_apart), 0);
  });
}

}  // namespace
}  // namespace stillray::stages_together_test
