// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Denoising with the future known: a sequence played backward, then forward.
#include <cmath>
#include <cstring>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "denoise/make_denoiser.h"
#include "denoise/stages/merge_future_shared.h"
#include "denoise/test_frames.h"
#include "stillray/denoise.hpp"

namespace stillray::future_test {
namespace {

using test::FillImage;
using test::Light;
using test::MakeBusyFrame;
using test::MakeDenoiser;
using test::MakeWall;
using ::testing::HasSubstr;

std::vector<FutureLight> PlayBackward(const Settings& s, const std::vector<Frame>& frames,
                                      Backend backend = Backend::kCpu) {
  std::vector<FutureLight> future(frames.size());
  Denoiser d = MakeDenoiser(s, backend);
  for (size_t i = frames.size(); i-- > 0;) {
    Frame reversed = frames[i];
    if (i + 1 < frames.size()) {
      reversed.guides.motion =
          ReverseMotion(frames[i + 1].guides.motion, frames[i + 1].guides.depth);
    }
    EXPECT_TRUE(d.Accumulate(reversed, &future[i]).ok());
  }
  return future;
}

/// Standard deviation and mean of the red channel.
std::pair<double, double> Spread(const Image3& image) {
  double sum = 0;
  double sum2 = 0;
  const double n = static_cast<double>(image.width()) * image.height();
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      sum += image[0](x, y);
      sum2 += static_cast<double>(image[0](x, y)) * image[0](x, y);
    }
  }
  return {std::sqrt(std::max(sum2 / n - sum * sum / (n * n), 0.0)), sum / n};
}

std::vector<Frame> NoisyWalls(int count) {
  std::vector<Frame> frames;
  for (int i = 0; i < count; ++i) {
    frames.push_back(MakeWall(64, 48, i));
    FillImage<3>(&Light(&frames.back(), SignalKind::kDirectDiffuse), [&](int x, int y, int) {
      return test::Random(static_cast<uint32_t>(i), static_cast<uint32_t>(x),
                          static_cast<uint32_t>(y));
    });
  }
  return frames;
}

TEST(Future, SharesAreInverseToTheNoise) {
  EXPECT_FLOAT_EQ(FutureShare(10, 0.1f, 10, 0.1f), 0.5f);
  EXPECT_FLOAT_EQ(FutureShare(1, 1.0f, 9, 1.0f / 9), 0.9f);  // 9 of 10 samples
  EXPECT_EQ(FutureShare(10, 0.1f, 0, 0.0f), 0.0f);
  EXPECT_EQ(FutureShare(0, 0.0f, 10, 0.1f), 1.0f);
  EXPECT_FLOAT_EQ(MergedWeights2(1.0f, 1.0f / 9, 0.9f), 0.1f);  // as one mean of 10
}

TEST(Future, WithAPlainMeanEveryFrameOfAStillViewIsTheMeanOfAll) {
  Settings s;
  s.wavelet = Wavelet::kOff;
  s.antialias = Antialias::kOff;
  s.limit_history = false;
  s.alpha_min = s.alpha_moments = 0;
  const std::vector<Frame> frames = NoisyWalls(7);
  const std::vector<FutureLight> future = PlayBackward(s, frames);
  Denoiser d = MakeDenoiser(s);
  ASSERT_TRUE(d.SetOutputs({"history"}).ok());
  for (size_t i = 0; i < frames.size(); ++i) {
    DenoisedFrame out;
    ASSERT_TRUE(d.Denoise(frames[i], future[i], &out).ok());
    for (const auto& [x, y] : {std::pair{3, 5}, {40, 20}, {63, 47}}) {
      double mean = 0;
      for (const Frame& f : frames) {
        mean += f.signals[0].radiance[0](x, y) / 7.0;
      }
      EXPECT_NEAR(out.colour[0](x, y), mean, 1e-5) << "frame " << i;
      EXPECT_FLOAT_EQ(out.images[0].channels[0](x, y), 7.0f);
    }
  }
}

TEST(Future, FirstFramesAreAsCleanAsTheRest) {
  Settings s;
  s.antialias = Antialias::kOff;
  const std::vector<Frame> frames = NoisyWalls(16);
  const std::vector<FutureLight> future = PlayBackward(s, frames);
  Denoiser alone = MakeDenoiser(s);
  Denoiser both = MakeDenoiser(s);
  DenoisedFrame first_alone;
  DenoisedFrame first_both;
  ASSERT_TRUE(alone.Denoise(frames[0], &first_alone).ok());
  ASSERT_TRUE(both.Denoise(frames[0], future[0], &first_both).ok());
  DenoisedFrame out;
  for (size_t i = 1; i < 9; ++i) {
    ASSERT_TRUE(both.Denoise(frames[i], future[i], &out).ok());
  }
  const auto [first_noise, first_mean] = Spread(first_both.colour);
  EXPECT_LT(first_noise, 0.6 * Spread(first_alone.colour).first);
  EXPECT_LT(first_noise, 1.5 * Spread(out.colour).first);
  EXPECT_NEAR(first_mean, 0.5, 0.005);
}

TEST(Future, VectorVersionMatchesTheReference) {
  Settings s;
  s.fxaa = Fxaa::kOff;  // decides at thresholds
  std::vector<Frame> frames;
  for (int i = 0; i < 5; ++i) {
    frames.push_back(MakeBusyFrame(67, 35, i));
  }
  const std::vector<FutureLight> slow = PlayBackward(s, frames, Backend::kReference);
  const std::vector<FutureLight> fast = PlayBackward(s, frames);
  Denoiser reference = MakeDenoiser(s, Backend::kReference);
  Denoiser cpu = MakeDenoiser(s);
  for (size_t i = 0; i < frames.size(); ++i) {
    DenoisedFrame a;
    DenoisedFrame b;
    ASSERT_TRUE(reference.Denoise(frames[i], slow[i], &a).ok());
    ASSERT_TRUE(cpu.Denoise(frames[i], fast[i], &b).ok());
    double error = 0;
    double square = 0;
    for (int y = 0; y < 35; ++y) {
      for (int x = 0; x < 67; ++x) {
        error += std::pow(static_cast<double>(a.colour[1](x, y)) - b.colour[1](x, y), 2);
        square += std::pow(static_cast<double>(a.colour[1](x, y)), 2);
      }
    }
    EXPECT_LT(std::sqrt(error / square), 1e-4) << "frame " << i;
  }
}

TEST(Future, TheHistoryStaysFreeOfIt) {
  const Settings s;
  const std::vector<Frame> frames = NoisyWalls(4);
  std::vector<FutureLight> future = PlayBackward(s, frames);
  Settings no_picture = s;
  no_picture.antialias = Antialias::kOff;
  Denoiser alone = MakeDenoiser(no_picture);
  Denoiser both = MakeDenoiser(no_picture);
  DenoisedFrame out;
  for (size_t i = 0; i < 3; ++i) {
    ASSERT_TRUE(alone.Denoise(frames[i], &out).ok());
    ASSERT_TRUE(both.Denoise(frames[i], future[i], &out).ok());
  }
  DenoisedFrame a;
  DenoisedFrame b;
  ASSERT_TRUE(alone.Denoise(frames[3], &a).ok());
  ASSERT_TRUE(both.Denoise(frames[3], &b).ok());
  for (int y = 0; y < 48; ++y) {
    EXPECT_EQ(std::memcmp(a.colour[0].Row(y), b.colour[0].Row(y), 64 * sizeof(float)), 0);
  }
}

TEST(Future, OfOtherFramesIsRefused) {
  const Settings s;
  const std::vector<Frame> frames = NoisyWalls(2);
  const std::vector<FutureLight> future = PlayBackward(s, frames);
  EXPECT_GT(future[0].bytes(), 64u * 48 * 4 * 7);
  Denoiser d = MakeDenoiser(s);
  DenoisedFrame out;
  EXPECT_THAT(d.Denoise(MakeWall(32, 32, 9), future[0], &out).message(),
              HasSubstr("frame 9: the light of its future has 3 signals of 64x48, expected 3 of "
                        "32x32"));
}

TEST(ReverseMotion, UndoesShiftsAndZooms) {
  Image2 shift(40, 30);
  shift[0].Fill(1.5f);
  shift[1].Fill(-0.75f);
  Image1 depth(40, 30);
  depth.Fill(1.0f);
  const Image2 back = ReverseMotion(shift, depth);
  EXPECT_NEAR(back[0](20, 15), -1.5f, 1e-5f);
  EXPECT_NEAR(back[1](20, 15), 0.75f, 1e-5f);
  // Points at p < 1 come from beyond the left edge: out of the picture one frame later.
  EXPECT_GT(back[0](0, 15), 40.0f);

  // A zoom about (20, 15): q was at 20 + 0.95 (q - 20), so p goes to 20 + (p - 20) / 0.95.
  Image2 zoom(40, 30);
  FillImage<2>(&zoom, [](int x, int y, int c) {
    return -0.05f * static_cast<float>(c == 0 ? x - 20 : y - 15);
  });
  const Image2 out = ReverseMotion(zoom, depth);
  for (const auto& [x, y] : {std::pair{10, 20}, {30, 8}, {20, 15}}) {
    EXPECT_NEAR(out[0](x, y), (x - 20) / 0.95 - (x - 20), 1e-3);
    EXPECT_NEAR(out[1](x, y), (y - 15) / 0.95 - (y - 15), 1e-3);
  }
}

TEST(ReverseMotion, NothingIsFoundBehindWhatMovedInFront) {
  // A block in columns 20..29 that moved 8 pixels from the left covers static surfaces.
  Image2 motion(60, 10);
  FillImage<2>(&motion,
               [](int x, int, int c) { return c == 0 && x >= 20 && x < 30 ? -8.0f : 0.0f; });
  Image1 depth(60, 10);
  FillImage(&depth, [](int x, int) { return x >= 20 && x < 30 ? 1.0f : 2.0f; });
  const Image2 out = ReverseMotion(motion, depth);
  EXPECT_NEAR(out[0](16, 5), 8.0f, 1e-4f);  // the block, seen from before
  EXPECT_NEAR(out[0](5, 5), 0.0f, 1e-4f);   // still all the time
  EXPECT_NEAR(out[0](50, 5), 0.0f, 1e-4f);
  EXPECT_GT(out[0](25, 5), 60.0f);  // behind the block one frame later
}

}  // namespace
}  // namespace stillray::future_test
