// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/stages/follow_light.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <vector>

#include <gtest/gtest.h>

#include "core/random.h"
#include "denoise/stages/follow_light_shared.h"
#include "denoise/test_frames.h"
#include "stage_test.h"
#include "stillray/denoise.hpp"

namespace stillray::follow_light_test {
namespace {

using test::FillImage;
using test::Light;
using test::MakeWall;

TEST(FollowLight, BlocksAndTheirPixels) {
  EXPECT_EQ(FollowSize(8), 2);
  EXPECT_EQ(FollowSize(9), 3);
  EXPECT_EQ(FollowPixel(0, 9), 2);
  EXPECT_EQ(FollowPixel(2, 9), 8);  // not beyond the picture
  EXPECT_EQ(FollowNearest(2.0f, 3), 0);
  EXPECT_EQ(FollowNearest(3.9f, 3), 0);
  EXPECT_EQ(FollowNearest(4.1f, 3), 1);
  EXPECT_EQ(FollowNearest(-1.0f, 3), 0);
  EXPECT_EQ(FollowNearest(40.0f, 3), 2);
}

TEST(FollowLight, ChangeIsTheLogarithmOfTheRatio) {
  EXPECT_NEAR(LogChange(3.0f, 2.0f), std::log(1.5), 1e-6);
  EXPECT_EQ(LogChange(100.0f, 1.0f), kMostChange);
  EXPECT_EQ(LogChange(1.0f, 100.0f), -kMostChange);
  EXPECT_EQ(LogChange(0.0f, 1.0f), 0.0f);
  EXPECT_EQ(LogChange(1.0f, 0.0f), 0.0f);
}

// Against sums in double precision.
TEST(FollowLight, OnlyWhatExceedsTheNoiseIsFollowed) {
  const std::vector<double> changes = {0.1, 0.12, 0.08, 0.11, 0.09, 0.1, 0.05, 0.15};
  double sum = 0;
  double squares = 0;
  for (const double change : changes) {
    sum += change;
    squares += change * change;
  }
  const auto known = static_cast<double>(changes.size());
  const double mean = sum / known;
  double variance = 0;
  for (const double change : changes) {
    variance += (change - mean) * (change - mean) / known / known;
  }
  const double share = (4 * variance + 0.006 * 0.006) / (mean * mean);
  EXPECT_NEAR(FollowedChange(static_cast<float>(sum), static_cast<float>(squares), 8),
              mean * (1 - share), 1e-6);
  // Blocks that disagree; a change within the noise of filters; too few blocks; and a bound.
  EXPECT_EQ(FollowedChange(0.1f, 8 * 0.04f, 8), 0);
  EXPECT_EQ(FollowedChange(8 * 0.005f, 8 * 0.005f * 0.005f, 8), 0);
  EXPECT_EQ(FollowedChange(0.5f, 0.05f, 5), 0);
  EXPECT_NEAR(FollowedChange(8, 8, 8), std::log(2.0), 1e-6);
  EXPECT_NEAR(FollowedChange(-8, 8, 8), -std::log(2.0), 1e-6);
}

/// A slope that turns away from the viewer, another wall to the right, sky below; ids to the left.
FollowedBlocks MakeBlocks(int width, int height, uint32_t seed) {
  FollowedBlocks b(width, height);
  const int wall = b.change.width() * 2 / 3;
  for (int y = 0; y < b.change.height(); ++y) {
    for (int x = 0; x < b.change.width(); ++x) {
      const bool sky = y > 6;
      b.known(x, y) = !sky && test::RandomAt(x, y, seed) < 0.9f ? 1.0f : 0.0f;
      b.change(x, y) = b.known(x, y) * (0.1f + 0.1f * test::RandomAt(x, y, seed + 1));
      b.inverse_depth(x, y) = sky ? 0.0f : x < wall ? 1 + 0.01f * static_cast<float>(x) : 2.0f;
      b.gradient[0](x, y) = !sky && x < wall ? 0.01f / kFollowBlock : 0.0f;
      b.normal[0](x, y) = sky ? 0.0f : std::sin(0.2f * static_cast<float>(y));
      b.normal[2](x, y) = sky ? 0.0f : std::cos(0.2f * static_cast<float>(y));
      b.id(x, y) = x < 2 ? static_cast<uint32_t>(x) : 0;
    }
  }
  return b;
}

TEST(FollowLight, VectorVersionIsTheReference) {
  test::ForSizesAndTargets([](int width, int height) {
    const FollowedBlocks blocks = MakeBlocks(4 * width, 4 * height, 7);
    Image1 expected(blocks.change.width(), blocks.change.height());
    Image1 found(blocks.change.width(), blocks.change.height());
    reference::FollowLight(blocks, &expected);
    cpu::FollowLight(blocks, &found);
    for (int y = 0; y < found.height(); ++y) {
      for (int x = 0; x < found.width(); ++x) {
        ASSERT_NEAR(found(x, y), expected(x, y), 1e-5) << x << " " << y;
      }
    }
  });
}

TEST(FollowLight, NothingIsFollowedNextToAnotherSurface) {
  FollowedBlocks blocks(80, 40);
  blocks.known.Fill(1);
  blocks.change.Fill(0.1f);
  for (int y = 0; y < blocks.change.height(); ++y) {
    for (int x = 0; x < blocks.change.width(); ++x) {
      blocks.inverse_depth(x, y) = x < 10 ? 1.0f : 2.0f;
      blocks.change(x, y) = x < 10 ? 0.1f : -0.3f;
      blocks.normal[2](x, y) = 1;
    }
  }
  Image1 ratio(blocks.change.width(), blocks.change.height());
  cpu::FollowLight(blocks, &ratio);
  for (int x = 0; x < ratio.width(); ++x) {
    const double change = x < 9 ? 0.1 : x < 11 ? 0.0 : -0.3;
    EXPECT_NEAR(ratio(x, 5), std::exp(change), 1e-3) << x;
  }
}

TEST(FollowLight, RatiosAreInterpolatedBetweenThePixelsOfBlocks) {
  const Image1 ratio = test::MakePlane(3, 2, [](int x, int y) { return 1 + x + 10.0f * y; });
  std::vector<float> row(11);
  FollowedRow(ratio, 4, 11, row.data());  // half way between the pixels at 2 and 6
  for (int x = 0; x < 11; ++x) {
    const float across = std::min(std::max((static_cast<float>(x) - 2) / 4, 0.0f), 2.0f);
    EXPECT_FLOAT_EQ(row[static_cast<size_t>(x)], 1 + across + 5) << x;
  }
  FollowedRow(ratio, 0, 11, row.data());
  EXPECT_FLOAT_EQ(row[10], 3);
  FollowedRow(ratio, 7, 11, row.data());
  EXPECT_FLOAT_EQ(row[0], 11);
}

/// A jittered wall with a texture under light that becomes brighter by a factor in every frame,
/// with noise. The texture's contrast lets a picture that lags pass the clamp of antialias.
Frame MakeBrighterWall(int index, float factor, float noise) {
  Frame f = MakeWall(64, 48, index);
  f.jitter_x = 0.25f * static_cast<float>(index % 3 - 1);
  f.jitter_y = 0.125f;
  const float light = std::pow(factor, static_cast<float>(index));
  const auto texture = [](int x, int y) { return (x + y) % 2 == 0 ? 0.2f : 0.8f; };
  FillImage<3>(&Light(&f, SignalKind::kDirectDiffuse), [&](int x, int y, int) {
    const float u = test::RandomAt(x, y, static_cast<uint32_t>(index));
    return texture(x, y) * light * (1 + noise * (u - 0.5f));
  });
  FillImage<3>(&f.guides.albedo, [&](int x, int y, int) { return texture(x, y); });
  return f;
}

float MeanOf(const Image3& image) {
  double sum = 0;
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      sum += static_cast<double>(image[1](x, y));
    }
  }
  return static_cast<float>(sum / image.width() / image.height());
}

/// The mean of the picture over that before antialiasing, after many frames.
float Lag(const Settings& s, float factor) {
  Denoiser d = Denoiser::Create(s).value();
  EXPECT_TRUE(d.SetOutputs({"aliased"}).ok());
  DenoisedFrame out;
  for (int i = 0; i < 20; ++i) {
    EXPECT_TRUE(d.Denoise(MakeBrighterWall(i, factor, 0.02f), &out).ok());
  }
  Image3 aliased(out.colour.width(), out.colour.height());
  for (size_t c = 0; c < 3; ++c) {
    aliased[static_cast<int>(c)] = out.images[0].channels[c];
  }
  return MeanOf(out.colour) / MeanOf(aliased);
}

TEST(FollowLight, ThePictureDoesNotLagBehindTheLight) {
  Settings s = PresetSettings("default").value();
  s.taa_clamp = TaaClamp::kPicture;
  EXPECT_NEAR(Lag(s, 1.02f), 1, 0.02);
  EXPECT_NEAR(Lag(s, 0.98f), 1, 0.02);
  s.taa_follow_light = false;
  EXPECT_LT(Lag(s, 1.02f), 0.93f);
}

struct Pictures {
  Image3 with, without;  ///< follow_light
};

/// The last pictures of a sequence.
Pictures PicturesOf(Frame (*make)(int index), int frames) {
  Settings s = PresetSettings("default").value();
  Denoiser with = Denoiser::Create(s).value();
  s.taa_follow_light = false;
  Denoiser without = Denoiser::Create(s).value();
  DenoisedFrame a;
  DenoisedFrame b;
  for (int i = 0; i < frames; ++i) {
    EXPECT_TRUE(with.Denoise(make(i), &a).ok());
    EXPECT_TRUE(without.Denoise(make(i), &b).ok());
  }
  return {a.colour, b.colour};
}

TEST(FollowLight, ConstantLightStaysConstant) {
  const Pictures p = PicturesOf([](int index) { return MakeBrighterWall(index, 1, 0); }, 12);
  for (int y = 0; y < p.with.height(); ++y) {
    for (int x = 0; x < p.with.width(); ++x) {
      ASSERT_NEAR(p.with[0](x, y), p.without[0](x, y), 1e-5) << x << " " << y;
    }
  }
}

/// A wall that moves to the left behind thin dark bars that move to the right, by a pixel per frame
/// each; all light is constant.
Frame MakeWallBehindBars(int index) {
  Frame f = MakeBrighterWall(index, 1, 0);
  for (int y = 0; y < f.height; ++y) {
    for (int x = 0; x < f.width; ++x) {
      const bool bar = (x + 60 - index) % 6 == 0;
      const float albedo = bar ? 0.5f : (x + index + y) % 2 == 0 ? 0.2f : 0.8f;
      f.guides.depth(x, y) = bar ? 4.0f : 5.0f;
      f.guides.motion[0](x, y) = bar ? -1.0f : 1.0f;
      for (int c = 0; c < 3; ++c) {
        f.guides.albedo[c](x, y) = albedo;
        Light(&f, SignalKind::kDirectDiffuse)[c](x, y) = albedo * (bar ? 0.3f : 1.0f);
      }
    }
  }
  return f;
}

/// The last frame's light beside a bar may be that of the bar.
TEST(FollowLight, WallsBehindBarsStayAsTheyAre) {
  const Pictures p = PicturesOf(MakeWallBehindBars, 16);
  EXPECT_NEAR(MeanOf(p.with) / MeanOf(p.without), 1, 1e-3);
}

}  // namespace
}  // namespace stillray::follow_light_test
