// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Antialiasing with taa_clamp=light: texture is kept, light is not.
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "denoise/stages/antialias_shared.h"
#include "denoise/test_frames.h"
#include "stillray/denoise.hpp"

namespace stillray::texture_clamp_test {
namespace {

using test::FillImage;
using test::Light;
using test::MakeWall;

constexpr int kWidth = 48;
constexpr int kHeight = 24;

TEST(TextureClamp, LightOfAPictureAndBack) {
  EXPECT_FLOAT_EQ(LightOfPicture(0.6f, 0.298f), 2.0f);
  EXPECT_FLOAT_EQ(PictureOfLight(2.0f, 0.298f), 0.6f);
  EXPECT_FLOAT_EQ(LightOfPicture(0.0f, 0.0f), 0.0f);
}

// Both pictures are means with the same weights, so that their quotient is a mean of the light of
// the surfaces in it: it is within their range, whatever their albedos are.
TEST(TextureClamp, LightOfAMixtureIsWithinThatOfItsParts) {
  for (const double share : {0.1, 0.5, 0.9}) {
    const double picture = share * 3.0 * (0.8 + 0.002) + (1 - share) * 0.5 * (0.1 + 0.002);
    const double albedo = share * 0.8 + (1 - share) * 0.1;
    const float light = LightOfPicture(static_cast<float>(picture), static_cast<float>(albedo));
    EXPECT_GT(light, 0.5f);
    EXPECT_LT(light, 3.0f);
  }
}

TEST(TextureClamp, SurfacesOfAPlaneAndOthers) {
  const vec2 gradient = {0.01f, 0.02f};
  EXPECT_TRUE(IsOnPlane(1.0f, gradient, 1.03f, vec2(1.0f, 1.0f)));
  EXPECT_TRUE(IsOnPlane(1.0f, gradient, 1.0f + 0.019f, vec2(0.0f, 0.0f)));
  EXPECT_FALSE(IsOnPlane(1.0f, gradient, 1.0f - 0.021f, vec2(0.0f, 0.0f)));
  EXPECT_FALSE(IsOnPlane(1.0f, gradient, 0.97f, vec2(1.0f, 1.0f)));
  EXPECT_TRUE(IsOnPlane(0.0f, vec2(0.0f, 0.0f), 0.0f, vec2(2.0f, 0.0f)));  // background
  EXPECT_FALSE(WasBesideSurface(1.0f, 0.8f, 1.2f));
  EXPECT_TRUE(WasBesideSurface(1.0f, 1.0f, 1.2f));
  EXPECT_TRUE(WasBesideSurface(1.0f, 0.0f, 1.0f));
  EXPECT_FALSE(WasBesideSurface(0.0f, 0.0f, 0.0f));
  EXPECT_TRUE(IsYoung(0, 0));
  EXPECT_TRUE(IsYoung(4, 1));
  EXPECT_FALSE(IsYoung(5, 1));
  EXPECT_TRUE(IsYoung(64, 16));
  EXPECT_TRUE(IsYoung(3, 0.1f));
}

TEST(TextureClamp, TheRangeOfThePictureIsWidenedByTheAlbedo) {
  EXPECT_FLOAT_EQ(WidenedHigh(2.0f, 0.398f, 0.198f), 4.0f);
  EXPECT_FLOAT_EQ(WidenedHigh(2.0f, 0.1f, 0.2f), 2.0f);  // never narrower
  EXPECT_FLOAT_EQ(WidenedHigh(2.0f, 0.1f, 0.01f), 2.0f);
  EXPECT_FLOAT_EQ(WidenedLow(2.0f, 0.098f, 0.198f), 1.0f);
  EXPECT_FLOAT_EQ(WidenedLow(2.0f, 0.3f, 0.2f), 2.0f);
}

/// A wall without reflections. \param albedo  of a pixel
template <typename Albedo>
Frame MakeTexture(int index, const Albedo& albedo) {
  Frame f = MakeWall(kWidth, kHeight, index);
  f.jitter_x = 0.25f * static_cast<float>(index % 4) - 0.375f;
  f.jitter_y = 0.125f;
  for (int c = 0; c < 3; ++c) {
    f.guides.specular_albedo[c].Fill(0);
  }
  FillImage<3>(&f.guides.albedo, [&](int x, int y, int) { return albedo(x, y); });
  return f;
}

void SetLight(float light, Frame* f) {
  FillImage<3>(&Light(f, SignalKind::kDirectDiffuse),
               [&](int x, int y, int c) { return light * f->guides.albedo[c](x, y); });
}

Settings SettingsWith(TaaClamp clamp) {
  Settings s = PresetSettings("default").value();
  s.taa_clamp = clamp;
  s.taa_follow_light = false;
  return s;
}

/// Steep lines, a quarter of a pixel wide: the rays of one frame in four meet them in three rows.
float LineAlbedo(int x, int y, int index) {
  return x % 8 == 3 && (index + y / 3) % 4 == 0 ? 0.8f : 0.2f;
}

/// The mean of a pixel on a line over the last period of the jitter.
double MeanOfLine(TaaClamp clamp, Backend backend) {
  Denoiser d = Denoiser::Create(SettingsWith(clamp), backend).value();
  DenoisedFrame out;
  double sum = 0;
  for (int i = 0; i < 64; ++i) {
    Frame f = MakeTexture(i, [&](int x, int y) { return LineAlbedo(x, y, i); });
    SetLight(2, &f);
    EXPECT_TRUE(d.Denoise(f, &out).ok());
    sum += i >= 60 ? static_cast<double>(out.colour[1](19, 12)) / 4 : 0.0;
  }
  return sum;
}

TEST(TextureClamp, LinesThatMostFramesMissAreKept) {
  constexpr double kExact = 2 * (0.25 * 0.8 + 0.75 * 0.2);
  for (const Backend backend : {Backend::kReference, Backend::kCpu}) {
    EXPECT_NEAR(MeanOfLine(TaaClamp::kLight, backend), kExact, 0.03 * kExact);
    EXPECT_LT(MeanOfLine(TaaClamp::kPicture, backend), 0.8 * kExact);
  }
}

/// Light that has changed under a texture of contrast, in the next frame, relative to the light.
float LightAfterAChange(TaaClamp clamp) {
  Settings s = SettingsWith(clamp);
  s.temporal = true;
  s.alpha_min = 1;  // only antialiasing has a memory
  Denoiser d = Denoiser::Create(s).value();
  DenoisedFrame out;
  for (int i = 0; i < 30; ++i) {
    Frame f = MakeTexture(i, [](int x, int y) { return (x + y) % 2 == 0 ? 0.1f : 0.9f; });
    SetLight(i < 29 ? 1.0f : 1.5f, &f);
    EXPECT_TRUE(d.Denoise(f, &out).ok());
  }
  return out.colour[1](20, 13) / 0.9f;
}

TEST(TextureClamp, LightThatChangesIsFollowedAtOnce) {
  EXPECT_NEAR(LightAfterAChange(TaaClamp::kLight), 1.5f, 0.03f);
  EXPECT_LT(LightAfterAChange(TaaClamp::kPicture), 1.2f);
}

TEST(TextureClamp, AConstantPictureStaysConstant) {
  Denoiser d = Denoiser::Create(SettingsWith(TaaClamp::kLight)).value();
  DenoisedFrame out;
  for (int i = 0; i < 12; ++i) {
    Frame f = MakeTexture(i, [](int, int) { return 0.3f; });
    SetLight(2, &f);
    ASSERT_TRUE(d.Denoise(f, &out).ok());
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        ASSERT_NEAR(out.colour[0](x, y), 0.6f, 1e-5f) << i << ": " << x << " " << y;
      }
    }
  }
}

// A texture that is replaced, such as a picture on a screen.
TEST(TextureClamp, ATextureThatChangesIsFollowedAtOnce) {
  Denoiser d = Denoiser::Create(SettingsWith(TaaClamp::kLight)).value();
  DenoisedFrame out;
  for (int i = 0; i < 30; ++i) {
    const float albedo = i < 29 ? 0.9f : 0.1f;
    Frame f = MakeTexture(i, [&](int, int) { return albedo; });
    SetLight(1, &f);
    ASSERT_TRUE(d.Denoise(f, &out).ok());
  }
  EXPECT_NEAR(out.colour[1](20, 13), 0.1f, 1e-4f);
}

/// A bright window behind white bars, before which the camera moves by 0.3 pixels per frame.
Frame MakeWindow(int index) {
  const float shift = 0.3f * static_cast<float>(index);
  const auto is_bar = [&](int x) {
    return std::fmod(static_cast<float>(x) + shift + 1200.0f, 16.0f) < 2.0f;
  };
  Frame f = MakeTexture(index, [&](int x, int) { return is_bar(x) ? 0.8f : 0.0f; });
  SetLight(0.5f, &f);
  f.emission = Image3(kWidth, kHeight);
  FillImage<3>(&f.emission, [&](int x, int, int) { return is_bar(x) ? 0.0f : 5.0f; });
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      f.guides.depth(x, y) = is_bar(x) ? 4.0f : 5.0f;
      f.guides.motion[0](x, y) = 0.3f;
    }
  }
  return f;
}

// It has no albedo, beside which that of the bars, as splines resample it, is large.
TEST(TextureClamp, WindowsBetweenBarsAreNotBrightened) {
  for (const Backend backend : {Backend::kReference, Backend::kCpu}) {
    Denoiser d = Denoiser::Create(SettingsWith(TaaClamp::kLight), backend).value();
    DenoisedFrame out;
    for (int i = 0; i < 40; ++i) {
      ASSERT_TRUE(d.Denoise(MakeWindow(i), &out).ok());
    }
    float most = 0;
    for (int x = 0; x < kWidth; ++x) {
      most = std::max(most, out.colour[1](x, 12));
    }
    EXPECT_NEAR(most, 5.0f, 0.001f);
  }
}

/// A white bar that moves by three pixels per frame in front of a black wall.
Frame MakeBar(int index) {
  const auto is_bar = [&](int x) { return x >= 3 * index - 9 && x < 3 * index; };
  Frame f = MakeTexture(index, [&](int x, int) { return is_bar(x) ? 0.9f : 0.1f; });
  SetLight(1, &f);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      f.guides.depth(x, y) = is_bar(x) ? 4.0f : 5.0f;
      f.guides.motion[0](x, y) = is_bar(x) ? -3.0f : 0.0f;
    }
  }
  return f;
}

TEST(TextureClamp, SurfacesLeaveNoTrailOfTheirAlbedo) {
  Denoiser d = Denoiser::Create(SettingsWith(TaaClamp::kLight)).value();
  DenoisedFrame out;
  constexpr int kLast = 12;
  for (int i = 0; i <= kLast; ++i) {
    ASSERT_TRUE(d.Denoise(MakeBar(i), &out).ok());
  }
  for (int x = 2; x < kWidth - 2; ++x) {
    if (x < 3 * kLast - 10 || x > 3 * kLast) {  // the wall, but for the pixels at the bar
      EXPECT_NEAR(out.colour[1](x, 12), 0.1f, 0.003f) << x;
    }
  }
}

}  // namespace
}  // namespace stillray::texture_clamp_test
