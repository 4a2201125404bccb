// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Frames with broken samples, broken frames, and frames of any size.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <iterator>
#include <string>

#include "denoise/make_denoiser.h"
#include "denoise/test_frames.h"
#include "stillray/denoise.hpp"

namespace stillray::denoiser_input_test {
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

/// A textured wall in noisy light, of which one frame has damage at one pixel.
Frame DamagedFrame(int64_t index, const std::function<void(Guides*)>& damage) {
  Frame f = test::MakeSparseLight(64, 48, index, 0);
  if (index == 3) {
    damage(&f.guides);
  }
  return f;
}

TEST(Denoiser, InfiniteAlbedoStaysOnePixel) {
  const auto set = [](Image3* image, float value) {
    for (int c = 0; c < 3; ++c) {
      (*image)[c](20, 20) = value;
    }
  };
  const std::function<void(Guides*)> damages[] = {
      [&](Guides* g) { set(&g->albedo, INFINITY); },
      [&](Guides* g) {
        set(&g->albedo, INFINITY);
        g->depth(20, 20) = INFINITY;
      },
      [&](Guides* g) {
        set(&g->albedo, INFINITY);
        set(&g->normal, INFINITY);
      },
      [&](Guides* g) {
        set(&g->albedo, NAN);
        g->depth(20, 20) = NAN;
      },
      [&](Guides* g) { set(&g->albedo, 3e38f); },
  };
  for (const Backend backend : {Backend::kCpu, Backend::kReference}) {
    std::vector<DenoisedFrame> clean(6);
    Denoiser undamaged = MakeDenoiser(PresetSettings("default").value(), backend);
    for (int i = 0; i < 6; ++i) {
      ASSERT_TRUE(
          undamaged.Denoise(DamagedFrame(i, [](Guides*) {}), &clean[static_cast<size_t>(i)]).ok());
    }
    for (size_t which = 0; which < std::size(damages); ++which) {
      Denoiser broken = MakeDenoiser(PresetSettings("default").value(), backend);
      DenoisedFrame b;
      for (int i = 0; i < 6; ++i) {
        const DenoisedFrame& a = clean[static_cast<size_t>(i)];
        ASSERT_TRUE(broken.Denoise(DamagedFrame(i, damages[which]), &b).ok());
        EXPECT_EQ(b.non_finite, i == 3 && which < 4 ? 2 : 0);  // diffuse: direct and indirect
        for (int y = 0; y < 48; ++y) {
          for (int x = 0; x < 64; ++x) {
            ASSERT_TRUE(std::isfinite(b.colour[0](x, y))) << which << " " << i << " " << x << y;
            // A missing sample changes the filtered light slightly, and nothing else.
            ASSERT_TRUE((x == 20 && y == 20) ||
                        std::fabs(a.colour[0](x, y) - b.colour[0](x, y)) < 0.5f)
                << which << " frame " << i << " at " << x << "," << y << ": " << a.colour[0](x, y)
                << " " << b.colour[0](x, y);
          }
        }
      }
    }
  }
}

TEST(Denoiser, RoundingBelowZeroIsZero) {
  // Half of a noisy picture's samples are black: were they missing where they are -1e-6, only the
  // bright ones would be left.
  for (const Backend backend : {Backend::kCpu, Backend::kReference}) {
    for (const char* preset : {"default", "svgf", "eaw"}) {
      const Settings s = PresetSettings(preset).value();
      Denoiser zeros = MakeDenoiser(s, backend);
      Denoiser rounded = MakeDenoiser(s, backend);
      DenoisedFrame a;
      DenoisedFrame b;
      for (int i = 0; i < 3; ++i) {
        ASSERT_TRUE(zeros.Denoise(test::MakeSparseLight(96, 64, i, 0), &a).ok());
        ASSERT_TRUE(rounded.Denoise(test::MakeSparseLight(96, 64, i, -1e-6f), &b).ok());
        EXPECT_EQ(b.negative, 0);
        EXPECT_TRUE(test::SameBits(a.colour, b.colour)) << preset << " frame " << i;
      }
    }
  }
}

TEST(Denoiser, NegativeLimitFollowsExposure) {
  // A third of a thousandth of the mean is rounding, a tenth is not, in any unit of light.
  Denoiser zeros = MakeDenoiser(PresetSettings("default").value());
  DenoisedFrame expected;
  ASSERT_TRUE(zeros.Denoise(test::MakeSparseLight(96, 64, 0, 0), &expected).ok());
  for (const float unit : {1e-9f, 0.7f, 1.0f, 3.0f, 1e12f}) {
    for (const auto& [dark, is_negative] :
         {std::pair(-3e-4f, false), std::pair(-0.1f, true), std::pair(-0.5f, true)}) {
      Denoiser d = MakeDenoiser(PresetSettings("default").value());
      DenoisedFrame out;
      const Frame f = test::MakeSparseLight(96, 64, 0, unit * dark, 3 * unit);
      ASSERT_TRUE(d.Denoise(f, &out).ok());
      EXPECT_EQ(out.negative > 0, is_negative) << unit << " " << dark;
      if (!is_negative) {
        EXPECT_NEAR(
            test::MeanOf(out.colour) / static_cast<double>(unit) / test::MeanOf(expected.colour), 1,
            1e-4);
      }
    }
  }
}

TEST(Denoiser, FirefliesDoNotRaiseTheNegativeLimit) {
  Denoiser d = MakeDenoiser(PresetSettings("default").value());
  Frame f = MakeWall(64, 64);
  Image3& light = Light(&f, SignalKind::kDirectDiffuse);
  FillImage<3>(&light, [](int, int, int) { return 1.0f; });
  light[0](20, 20) = 1e30f;
  light[0](40, 40) = light[1](40, 40) = -0.5f;
  light[2](41, 40) = -1e-5f;
  DenoisedFrame out;
  ASSERT_TRUE(d.Denoise(f, &out).ok());
  EXPECT_EQ(out.negative, 1);
}

TEST(Denoiser, ConstantLightStaysConstantBesideRounding) {
  Denoiser d = MakeDenoiser(PresetSettings("default").value());
  for (int i = 0; i < 3; ++i) {
    Frame f = MakeWall(64, 48, i);
    FillImage<3>(&Light(&f, SignalKind::kDirectDiffuse), [](int, int, int) { return 0.5f; });
    FillImage<3>(&Light(&f, SignalKind::kIndirectDiffuse),
                 [](int x, int y, int) { return (x + y) % 2 == 0 ? -6e-8f : -0.0f; });
    DenoisedFrame out;
    ASSERT_TRUE(d.Denoise(f, &out).ok());
    EXPECT_EQ(out.negative, 0);
    for (int y = 0; y < 48; ++y) {
      for (int x = 0; x < 64; ++x) {
        ASSERT_NEAR(out.colour[1](x, y), 0.5f, 1e-6f) << x << " " << y;
      }
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
  f.signals[0].radiance = Image3();
  EXPECT_THAT(message(f), HasSubstr("frame 2: image 'direct_diffuse' is missing, expected 16x9"));
  f = MakeWall(16, 9, 2);
  f.guides.normal[1] = Image1(8, 9);
  EXPECT_THAT(message(f), HasSubstr("image 'normal[1]' is 8x9, expected 16x9"));
  f = MakeWall(16, 9, 2);
  f.guides.motion = Image2();
  EXPECT_THAT(message(f), HasSubstr("'motion' is missing"));
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

TEST(Denoiser, PositionsNeedTheFocalLength) {
  Settings settings;
  settings.depth_weight = DepthWeight::kPosition;
  Denoiser d = MakeDenoiser(settings);
  DenoisedFrame out;
  Frame f = MakeWall(16, 9, 3);
  f.focal_pixels = 0;
  const Status status = d.Denoise(f, &out);
  EXPECT_EQ(status.code(), StatusCode::kInvalidArgument);
  EXPECT_THAT(status.message(),
              HasSubstr("frame 3: depth_weight=position needs the focal length of the frame: give "
                        "files with worldToCamera and worldToNDC"));
  for (const float wrong : {-1.0f, std::nanf(""), INFINITY}) {
    f.focal_pixels = wrong;
    EXPECT_THAT(d.Denoise(f, &out).message(), HasSubstr("focal_pixels is"));
  }
  f.focal_pixels = 20;
  EXPECT_TRUE(d.Denoise(f, &out).ok());
  f.focal_pixels = 0;
  EXPECT_TRUE(MakeDenoiser(Settings()).Denoise(f, &out).ok());
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
}  // namespace stillray::denoiser_input_test
