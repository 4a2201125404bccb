// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Frames with broken samples, broken frames, and frames of any size.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "denoise/make_denoiser.h"
#include "denoise/test_frames.h"
#include "stillray/denoise.hpp"

namespace stillray {
namespace {

using test::FillImage;
using test::Light;
using test::MakeBusyFrame;
using test::MakeDenoiser;
using test::MakeWall;
using ::testing::HasSubstr;

TEST(Denoiser, BrokenSamplesTouchNothingElse) {
  // A clean sequence and one in which a few samples are broken: all other pixels get at least a
  // usable value, and pixels out of reach of the wavelet are bit for bit the same.
  Settings s = PresetSettings("default").value();
  s.steps = {2, {1, 2}};
  Denoiser clean = MakeDenoiser(s);
  Denoiser broken = MakeDenoiser(s);
  DenoisedFrame a;
  DenoisedFrame b;
  for (int i = 0; i < 5; ++i) {
    Frame f = MakeWall(64, 64, i);
    FillImage<3>(&Light(&f, SignalKind::kDirectDiffuse), [&](int x, int y, int) {
      return test::Random(static_cast<uint32_t>(i), static_cast<uint32_t>(x),
                          static_cast<uint32_t>(y));
    });
    ASSERT_TRUE(clean.Denoise(f, &a).ok());
    Image3& light = Light(&f, SignalKind::kDirectDiffuse);
    light[0](8, 8) = NAN;
    light[1](9, 8) = INFINITY;
    light[2](8, 9) = -3;
    f.guides.depth(50, 50) = NAN;
    f.guides.normal[1](52, 50) = INFINITY;
    f.guides.motion[0](50, 52) = NAN;
    ASSERT_TRUE(broken.Denoise(f, &b).ok());
    EXPECT_EQ(b.non_finite, 2);
    EXPECT_EQ(b.negative, 1);
    EXPECT_EQ(b.bad_guides, 2);
    for (int y = 0; y < 64; ++y) {
      for (int x = 0; x < 64; ++x) {
        EXPECT_TRUE(std::isfinite(b.colour[0](x, y)) && b.colour[0](x, y) >= 0) << x << " " << y;
      }
    }
  }
  // TAA's and limit_history's reach and the means over the picture are global: switch both off for
  // bits.
  s.antialias = Antialias::kOff;
  s.limit_history = false;
  Denoiser clean2 = MakeDenoiser(s);
  Denoiser broken2 = MakeDenoiser(s);
  for (int i = 0; i < 3; ++i) {
    Frame f = MakeBusyFrame(64, 64, 0);
    ASSERT_TRUE(clean2.Denoise(f, &a).ok());
    Light(&f, SignalKind::kDirectDiffuse)[0](8, 8) = NAN;
    ASSERT_TRUE(broken2.Denoise(f, &b).ok());
  }
  for (int y = 0; y < 64; ++y) {
    for (int x = 40; x < 64; ++x) {
      EXPECT_EQ(a.colour[0](x, y), b.colour[0](x, y));
    }
  }
}

TEST(Denoiser, BrokenSampleIsFilledFromItsSurface) {
  Denoiser d = MakeDenoiser(PresetSettings("default").value());
  Frame f = MakeWall(32, 32);
  FillImage<3>(&Light(&f, SignalKind::kDirectDiffuse), [](int, int, int) { return 0.5f; });
  Light(&f, SignalKind::kDirectDiffuse)[1](16, 16) = NAN;
  DenoisedFrame out;
  ASSERT_TRUE(d.Denoise(f, &out).ok());
  EXPECT_NEAR(out.colour[1](16, 16), 0.5f, 1e-5f);
}

TEST(Denoiser, BadFramesAreRefusedAndHistoryStays) {
  Denoiser d = MakeDenoiser(Settings());
  DenoisedFrame out;
  const auto message = [&](const Frame& f) {
    const Status status = d.Denoise(f, &out);
    EXPECT_EQ(status.code(), StatusCode::kInvalidArgument);
    return status.message();
  };
  ASSERT_TRUE(d.Denoise(MakeWall(16, 9, 1), &out).ok());
  const std::vector<uint8_t> before = d.SaveHistory().value();
  Frame f = MakeWall(16, 9, 2);
  f.guides.depth = Image1();
  EXPECT_THAT(message(f), HasSubstr("frame 2: image 'depth' is missing, expected 16x9"));
  f = MakeWall(16, 9, 2);
  f.guides.normal[1] = Image1(8, 9);
  EXPECT_THAT(message(f), HasSubstr("image 'normal[1]' is 8x9, expected 16x9"));
  f = MakeWall(16, 9, 2);
  f.guides.motion = Image2();
  EXPECT_THAT(message(f), HasSubstr("'motion[0]' is missing"));
  f = MakeWall(16, 9, 2);
  f.signals.push_back(f.signals[0]);
  EXPECT_THAT(message(f), HasSubstr("'direct_diffuse' is given twice"));
  f.signals.clear();
  EXPECT_THAT(message(f), HasSubstr("no signals"));
  f = Frame();
  EXPECT_THAT(message(f), HasSubstr("size is 0x0"));
  EXPECT_EQ(d.SaveHistory().value(), before);
  EXPECT_THAT(d.SetOutputs({"varience"}).message(), HasSubstr("unknown output 'varience'"));
}

TEST(Denoiser, SizesFromOnePixelUpWork) {
  for (const auto& [width, height] :
       {std::pair{1, 1}, std::pair{2, 1}, std::pair{1, 7}, std::pair{17, 3}, std::pair{33, 65}}) {
    for (const std::string_view preset : PresetNames()) {
      Denoiser d = MakeDenoiser(PresetSettings(preset).value());
      DenoisedFrame out;
      for (int i = 0; i < 3; ++i) {
        ASSERT_TRUE(d.Denoise(MakeBusyFrame(width, height, i), &out).ok());
        EXPECT_TRUE(std::isfinite(out.colour[0](width - 1, height - 1)));
      }
    }
  }
}

}  // namespace
}  // namespace stillray
