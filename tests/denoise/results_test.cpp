// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The forms in which a denoiser returns a finished picture. The same on Vulkan: tests/gpu.
#include <gtest/gtest.h>

#include "denoise/make_denoiser.h"
#include "denoise/test_frames.h"
#include "stillray/denoise.hpp"

namespace stillray::results_test {
namespace {

using test::MakeBusyFrame;
using test::MakeDenoiser;
using test::SameBits;

TEST(Results, TheDisplayIsWhatToDisplayMakes) {
  Settings settings;
  settings.exposure = -0.5f;
  settings.tonemap = Tonemap::kReinhard;
  settings.dither = 1;
  for (const Antialias antialias : {Antialias::kOff, Antialias::kTaa}) {
    settings.antialias = antialias;
    Denoiser d = MakeDenoiser(settings);
    d.SetResults({.colour = true, .display = true});
    DenoisedFrame out;
    for (int i = 0; i < 3; ++i) {
      ASSERT_TRUE(d.Denoise(MakeBusyFrame(37, 21, i), &out).ok());
      EXPECT_EQ(out.display, ToDisplay(out.colour, -0.5f, Tonemap::kReinhard, 1, i)) << i;
    }
  }
}

TEST(Results, WhatIsNotWantedIsEmptyAndCanBeReadLater) {
  Denoiser d = MakeDenoiser(Settings());
  Denoiser plain = MakeDenoiser(Settings());
  Image3 late;
  EXPECT_EQ(d.ReadColour(&late).code(), StatusCode::kNotFound);
  DenoisedFrame out;
  DenoisedFrame expected;
  int i = 0;
  for (const auto& [colour, display] : {std::pair(true, true), std::pair(false, true),
                                        std::pair(false, false), std::pair(true, false)}) {
    d.SetResults({.colour = colour, .display = display});
    ASSERT_TRUE(d.Denoise(MakeBusyFrame(24, 13, i), &out).ok());
    ASSERT_TRUE(plain.Denoise(MakeBusyFrame(24, 13, i), &expected).ok());
    EXPECT_TRUE(expected.display.empty()) << "unless asked for";
    EXPECT_EQ(out.colour.empty(), !colour) << i;
    EXPECT_EQ(out.display.empty(), !display) << i;
    ASSERT_TRUE(d.ReadColour(&late).ok());
    EXPECT_TRUE(SameBits(late, expected.colour)) << "nothing else changes, frame " << i;
    ++i;
  }
}

TEST(Results, TheCpuSharesNothing) {
  Denoiser d = MakeDenoiser(Settings());
  d.SetResults({.colour = true, .display = false, .shared = true});
  DenoisedFrame out;
  ASSERT_TRUE(d.Denoise(MakeBusyFrame(24, 13, 0), &out).ok());
  EXPECT_EQ(out.shared, nullptr);
  EXPECT_EQ(out.display, ToDisplay(out.colour, 0, Tonemap::kAces)) << "it stands in";
}

TEST(Results, ARestoredHistoryHasNoFinishedFrame) {
  Denoiser d = MakeDenoiser(Settings());
  DenoisedFrame out;
  ASSERT_TRUE(d.Denoise(MakeBusyFrame(24, 13, 0), &out).ok());
  const std::vector<uint8_t> saved = d.SaveHistory().value();
  ASSERT_TRUE(d.RestoreHistory(saved).ok());
  Image3 late;
  EXPECT_EQ(d.ReadColour(&late).code(), StatusCode::kNotFound);
  ASSERT_TRUE(d.Denoise(MakeBusyFrame(24, 13, 1), &out).ok());
  ASSERT_TRUE(d.ReadColour(&late).ok());
  EXPECT_TRUE(SameBits(late, out.colour));
}

}  // namespace
}  // namespace stillray::results_test
