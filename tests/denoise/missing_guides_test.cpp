// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Frames without guides, and frames whose guides say nothing.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/guides.h"
#include "core/second_moments.h"
#include "denoise/make_denoiser.h"
#include "denoise/test_frames.h"
#include "stillray/denoise.hpp"

namespace stillray::missing_guides_test {
namespace {

using test::MakeBusyFrame;
using test::MakeDenoiser;
using test::MakeWall;
using ::testing::HasSubstr;

constexpr int kWidth = 40;
constexpr int kHeight = 24;
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

Settings Default() {
  return PresetSettings("default").value();
}

/// Light only, as from a renderer without guides.
Frame ColourAlone(int64_t index) {
  Frame busy = MakeBusyFrame(kWidth, kHeight, index);
  Frame frame;
  frame.width = kWidth;
  frame.height = kHeight;
  frame.index = index;
  frame.signals.push_back(std::move(busy.signals.front()));
  return frame;
}

void ExpectSameBits(const Image3& a, const Image3& b) {
  for (int c = 0; c < 3; ++c) {
    for (int y = 0; y < a.height(); ++y) {
      ASSERT_EQ(std::memcmp(a[c].Row(y), b[c].Row(y), sizeof(float) * static_cast<size_t>(kWidth)),
                0)
          << c << " " << y;
    }
  }
}

TEST(MissingGuides, ColourAloneIsFilteredAsWithFlatGuides) {
  Denoiser alone = MakeDenoiser(Default());
  Denoiser flat = MakeDenoiser(Default());
  DenoisedFrame a;
  DenoisedFrame b;
  const Frame frame = ColourAlone(0);
  ASSERT_TRUE(alone.Denoise(frame, &a).ok());
  Frame given = frame;
  given.guides.depth = FlatDepth(kWidth, kHeight);
  given.guides.normal = FlatNormal(kWidth, kHeight);
  given.guides.albedo = WhiteAlbedo(kWidth, kHeight);
  given.guides.motion = Image2(kWidth, kHeight);
  ASSERT_TRUE(flat.Denoise(given, &b).ok());
  ExpectSameBits(a.colour, b.colour);
  EXPECT_TRUE(frame.guides.depth.empty());  // the caller's frame stays as it is
  EXPECT_EQ(a.warning, "");
  // It is filtered: it differs from the input.
  EXPECT_NE(a.colour[0](20, 12), frame.signals[0].radiance[0](20, 12));
}

TEST(MissingGuides, EachOnItsOwn) {
  const auto denoise = [](const Frame& frame) {
    Denoiser d = MakeDenoiser(Default());
    DenoisedFrame out;
    for (int i = 0; i < 2; ++i) {
      const Status status = d.Denoise(frame, &out);
      EXPECT_TRUE(status.ok()) << status.message();
    }
    return out.colour;
  };
  const Frame whole = MakeBusyFrame(kWidth, kHeight, 0);
  const auto expect_stand_in = [&](auto* image_of, const auto& stand_in) {
    Frame without = whole;
    *image_of(&without.guides) = {};
    Frame with = whole;
    *image_of(&with.guides) = stand_in;
    ExpectSameBits(denoise(without), denoise(with));
  };
  expect_stand_in(
      +[](Guides* g) { return &g->depth; }, FlatDepth(kWidth, kHeight));
  expect_stand_in(
      +[](Guides* g) { return &g->normal; }, FlatNormal(kWidth, kHeight));
  expect_stand_in(
      +[](Guides* g) { return &g->albedo; }, WhiteAlbedo(kWidth, kHeight));
  expect_stand_in(
      +[](Guides* g) { return &g->specular_albedo; }, WhiteAlbedo(kWidth, kHeight));
}

TEST(MissingGuides, MotionIsNeededFromTheSecondFrameOn) {
  Denoiser d = MakeDenoiser([] {
    Settings s = Default();
    s.antialias = Antialias::kTaa;
    return s;
  }());
  DenoisedFrame out;
  ASSERT_TRUE(d.Denoise(ColourAlone(0), &out).ok());
  const std::vector<uint8_t> before = d.SaveHistory().value();
  const Status status = d.Denoise(ColourAlone(1), &out);
  EXPECT_EQ(status.code(), StatusCode::kInvalidArgument);
  EXPECT_EQ(status.message(),
            "frame 1: image 'motion' is missing, expected 40x24: 'temporal' and 'antialias' follow "
            "it from frame to frame (zero where nothing moves; 'off' needs none)");
  EXPECT_EQ(d.SaveHistory().value(), before);
  Settings s = d.settings();
  s.temporal = false;
  ASSERT_TRUE(d.SetSettings(s).ok());
  EXPECT_THAT(d.Denoise(ColourAlone(1), &out).message(), HasSubstr("'antialias' follows it"));
  s.antialias = Antialias::kOff;
  ASSERT_TRUE(d.SetSettings(s).ok());
  EXPECT_TRUE(d.Denoise(ColourAlone(1), &out).ok());
  EXPECT_TRUE(d.Denoise(ColourAlone(2), &out).ok());
  ASSERT_TRUE(d.SetSettings(Default()).ok());
  d.Reset();
  EXPECT_TRUE(d.Denoise(ColourAlone(3), &out).ok());
}

TEST(MissingGuides, AnotherSizeIsAFirstFrame) {
  Denoiser d = MakeDenoiser(Default());
  DenoisedFrame out;
  ASSERT_TRUE(d.Denoise(MakeBusyFrame(16, 12, 0), &out).ok());
  EXPECT_TRUE(d.Denoise(ColourAlone(1), &out).ok());
}

// Unknown guides of a sparse frame are gathered from the last frame along the motion.
TEST(MissingGuides, FillingUnknownGuidesNeedsMotion) {
  Settings s = Default();
  s.temporal = false;
  s.antialias = Antialias::kOff;
  Denoiser d = MakeDenoiser(s);
  Frame frame = MakeBusyFrame(kWidth, kHeight, 0);
  frame.samples = Image1(kWidth, kHeight);
  frame.samples.Fill(1);
  frame.samples(5, 5) = 0;
  frame.guides.depth(5, 5) = 0;
  frame.guides.motion = Image2();
  DenoisedFrame out;
  EXPECT_THAT(d.Denoise(frame, &out).message(), HasSubstr("'fill_guides' follows it"));
}

TEST(MissingGuides, AChannelThatIsMissingIsAMistake) {
  Denoiser d = MakeDenoiser(Default());
  DenoisedFrame out;
  Frame frame = MakeWall(kWidth, kHeight);
  frame.guides.normal[0] = Image1();
  EXPECT_THAT(d.Denoise(frame, &out).message(), HasSubstr("image 'normal[0]' is missing"));
}

TEST(UnusableDepth, NegativeEverywhereIsAnotherConvention) {
  Denoiser d = MakeDenoiser(Default());
  DenoisedFrame out;
  Frame frame = MakeWall(kWidth, kHeight, 3);
  frame.guides.depth.Fill(-5);
  const Status status = d.Denoise(frame, &out);
  EXPECT_EQ(status.code(), StatusCode::kInvalidArgument);
  EXPECT_EQ(status.message(),
            "frame 3: all depths are negative (960 pixels), expected linear view-space z > 0: "
            "negate the z of OpenGL's view space");
  frame.guides.depth.Fill(kNan);
  EXPECT_THAT(d.Denoise(frame, &out).message(), HasSubstr("all depths are NaN (960 pixels)"));
  // Sky as OpenGL users write it changes nothing.
  frame.guides.depth.Fill(-5);
  std::fill_n(frame.guides.depth.Row(0), kWidth, kInfinity);
  EXPECT_THAT(d.Denoise(frame, &out).message(), HasSubstr("all depths are negative"));
}

TEST(UnusableDepth, SomePixelsAreDamage) {
  Denoiser d = MakeDenoiser(Default());
  DenoisedFrame out;
  Frame frame = MakeWall(kWidth, kHeight);
  frame.guides.depth.Fill(-5);
  frame.guides.depth(3, 3) = 5;  // one surface
  EXPECT_TRUE(d.Denoise(frame, &out).ok());
  EXPECT_EQ(out.bad_guides, kWidth * kHeight - 1);
  frame.guides.depth.Fill(kInfinity);  // sky, and damage in it
  frame.guides.depth(3, 3) = kNan;
  frame.guides.depth(4, 3) = -1;
  EXPECT_TRUE(d.Denoise(frame, &out).ok());
}

TEST(OddValues, NormalsThatAreAllZeroAreReported) {
  Denoiser d = MakeDenoiser(Default());
  DenoisedFrame out;
  Frame frame = MakeBusyFrame(kWidth, kHeight, 0);
  const int64_t sky = [&] {
    int64_t count = 0;
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        count += frame.guides.depth(x, y) == kInfinity ? 1 : 0;
      }
    }
    return count;
  }();
  frame.guides.normal = Image3(kWidth, kHeight);
  ASSERT_TRUE(d.Denoise(frame, &out).ok());
  EXPECT_EQ(out.warning,
            "frame 0: image 'normal' is zero at every surface, expected unit length (or no such "
            "image): nothing is filtered");
  EXPECT_EQ(out.bad_guides, int64_t{kWidth} * kHeight - sky);
  // Not of a frame of sky.
  frame.guides.depth.Fill(kInfinity);
  ASSERT_TRUE(d.Denoise(frame, &out).ok());
  EXPECT_EQ(out.warning, "");
  // Nor of one that has a normal anywhere.
  ASSERT_TRUE(d.Denoise(MakeBusyFrame(kWidth, kHeight, 1), &out).ok());
  EXPECT_EQ(out.warning, "");
}

/// A grey wall in noisy light, the mean of 8 samples, without second moments.
Frame NoisyWall(int64_t index) {
  Frame frame = MakeWall(kWidth, kHeight, index);
  frame.signals.resize(1);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const float noise = test::Random(static_cast<uint32_t>(index), static_cast<uint32_t>(x),
                                       static_cast<uint32_t>(y));
      for (int c = 0; c < 3; ++c) {
        frame.signals[0].radiance[c](x, y) = frame.guides.albedo[c](x, y) * (0.5f + noise);
      }
    }
  }
  frame.samples = Image1(kWidth, kHeight);
  frame.samples.Fill(8);
  return frame;
}

double SquaredError(const Image3& colour) {
  const float albedo = MakeWall(kWidth, kHeight).guides.albedo[1](0, 0);
  double sum = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const double d = colour[1](x, y) / albedo - 1;
      sum += d * d / (kWidth * kHeight);
    }
  }
  return sum;
}

/// The pictures of three frames, and of their estimated moments.
void DenoiseWalls(const Settings& settings, DenoisedFrame* without, DenoisedFrame* with) {
  Denoiser a = MakeDenoiser(settings);
  Denoiser b = MakeDenoiser(settings);
  for (int64_t i = 0; i < 3; ++i) {
    Frame frame = NoisyWall(i);
    ASSERT_TRUE(a.Denoise(frame, without).ok());
    EXPECT_TRUE(frame.signals[0].second_moment.empty());  // the caller's frame stays as it is
    EstimateSecondMoments(&frame);
    ASSERT_TRUE(b.Denoise(frame, with).ok());
  }
}

TEST(MissingMoments, AreEstimated) {
  DenoisedFrame without;
  DenoisedFrame with;
  DenoiseWalls(Default(), &without, &with);
  ExpectSameBits(without.colour, with.colour);
  // A first frame is filtered: there is no variance over time yet.
  Denoiser first = MakeDenoiser(Default());
  ASSERT_TRUE(first.Denoise(NoisyWall(0), &without).ok());
  EXPECT_LT(SquaredError(without.colour), 0.1 * SquaredError(NoisyWall(0).signals[0].radiance));
}

TEST(MissingMoments, AreNotOfPublishedPresets) {
  DenoisedFrame without;
  DenoisedFrame with;
  DenoiseWalls(PresetSettings("svgf").value(), &without, &with);
  EXPECT_NE(SquaredError(without.colour), SquaredError(with.colour));
}

TEST(MissingMoments, OfInvalidFramesAreNotEstimated) {
  Denoiser d = MakeDenoiser(Default());
  DenoisedFrame out;
  Frame frame = NoisyWall(0);
  frame.samples = Image1(kWidth, kHeight - 1);
  frame.samples.Fill(8);
  const Status samples = d.Denoise(frame, &out);
  EXPECT_EQ(samples.code(), StatusCode::kInvalidArgument);
  EXPECT_THAT(samples.message(), HasSubstr("samples"));
  frame = NoisyWall(0);
  frame.guides.id = Plane<uint32_t>(kWidth - 1, kHeight);
  EXPECT_THAT(d.Denoise(frame, &out).message(), HasSubstr("id"));
  frame = NoisyWall(0);
  frame.guides.depth.Fill(kNan);
  EXPECT_THAT(d.Denoise(frame, &out).message(), HasSubstr("depth"));
}

TEST(OddValues, MotionThatIsNowhereFiniteIsReportedWhereItIsRead) {
  Denoiser d = MakeDenoiser(Default());
  DenoisedFrame out;
  Frame frame = MakeWall(kWidth, kHeight);
  frame.guides.motion[1].Fill(kNan);
  ASSERT_TRUE(d.Denoise(frame, &out).ok());
  EXPECT_EQ(out.warning, "");  // a first frame has nothing to follow
  ++frame.index;
  ASSERT_TRUE(d.Denoise(frame, &out).ok());
  EXPECT_EQ(out.warning,
            "frame 1: image 'motion' is not finite at any pixel, expected pixels: no history is "
            "found");
  frame.guides.motion[1](0, 0) = 0;
  ASSERT_TRUE(d.Denoise(frame, &out).ok());
  EXPECT_EQ(out.warning, "");
}

}  // namespace
}  // namespace stillray::missing_guides_test
