// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// antialias=auto: antialiasing in time runs where the frames are jittered, and nowhere else.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "denoise/make_denoiser.h"
#include "denoise/test_frames.h"
#include "stillray/denoise.hpp"

namespace stillray::jitter_test {
namespace {

using test::MakeBusyFrame;
using test::MakeDenoiser;
using test::SameBits;
using ::testing::HasSubstr;

constexpr int kWidth = 40;
constexpr int kHeight = 30;

Frame Busy(int index, bool jittered) {
  Frame f = MakeBusyFrame(kWidth, kHeight, index);
  f.jitter_x = jittered ? 0.25f : 0.0f;
  f.jitter_y = 0;
  return f;
}

/// The picture after four frames; `jittered[i]` says which are.
Image3 Picture(const Settings& settings, const std::vector<bool>& jittered) {
  Denoiser denoiser = MakeDenoiser(settings);
  DenoisedFrame out;
  for (size_t i = 0; i < jittered.size(); ++i) {
    EXPECT_TRUE(denoiser.Denoise(Busy(static_cast<int>(i), jittered[i]), &out).ok());
  }
  return out.colour;
}

TEST(Antialias, RunsWhereFramesAreJittered) {
  for (const char* preset : {"default", "svgf", "psvgf"}) {
    Settings settings = PresetSettings(preset).value();
    ASSERT_EQ(settings.antialias, Antialias::kAuto) << preset;
    settings.limit_history = false;  // expects differences by jitter
    const Image3 still = Picture(settings, {false, false, false, false});
    const Image3 jittered = Picture(settings, {true, true, true, true});
    // A sequence whose jitter passes through (0, 0) goes on being antialiased.
    const Image3 through_zero = Picture(settings, {true, true, false, false});
    settings.antialias = Antialias::kTaa;
    const Image3 taa = Picture(settings, {false, false, false, false});
    settings.antialias = Antialias::kOff;
    const Image3 off = Picture(settings, {true, true, true, true});
    EXPECT_FALSE(SameBits(taa, off)) << preset;
    EXPECT_TRUE(SameBits(still, off)) << preset;
    EXPECT_TRUE(SameBits(jittered, taa)) << preset;
    EXPECT_TRUE(SameBits(through_zero, taa)) << preset;
  }
}

TEST(Antialias, ACutForgetsTheJitter) {
  Denoiser denoiser = MakeDenoiser(Settings());
  DenoisedFrame out;
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(denoiser.Denoise(Busy(i, true), &out).ok());
  }
  denoiser.Reset();
  for (int i = 0; i < 4; ++i) {
    ASSERT_TRUE(denoiser.Denoise(Busy(i, false), &out).ok());
  }
  EXPECT_TRUE(SameBits(out.colour, Picture(Settings(), {false, false, false, false})));
}

TEST(Antialias, ASavedHistoryRemembersTheJitter) {
  Denoiser whole = MakeDenoiser(Settings());
  DenoisedFrame expected;
  ASSERT_TRUE(whole.Denoise(Busy(0, true), &expected).ok());
  Denoiser resumed = MakeDenoiser(Settings());
  ASSERT_TRUE(resumed.RestoreHistory(whole.SaveHistory().value()).ok());
  DenoisedFrame out;
  for (int i = 1; i < 3; ++i) {
    ASSERT_TRUE(whole.Denoise(Busy(i, false), &expected).ok());
    ASSERT_TRUE(resumed.Denoise(Busy(i, false), &out).ok());
  }
  EXPECT_TRUE(SameBits(out.colour, expected.colour));
}

TEST(Antialias, OnlyJitteredFramesNeedMotionForIt) {
  Settings settings;
  settings.temporal = false;
  Denoiser denoiser = MakeDenoiser(settings);
  DenoisedFrame out;
  Frame f = Busy(0, false);
  f.guides.motion = Image2();
  const Status still = denoiser.Denoise(f, &out);
  EXPECT_TRUE(still.ok()) << still.message();
  f.jitter_x = 0.25f;
  const Status first = denoiser.Denoise(f, &out);  // there is no picture yet to follow it to
  EXPECT_TRUE(first.ok()) << first.message();
  EXPECT_THAT(denoiser.Denoise(f, &out).message(),
              HasSubstr("'motion' is missing, expected 40x30: 'antialias' follows it"));
}

}  // namespace
}  // namespace stillray::jitter_test
