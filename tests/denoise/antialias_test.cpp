// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Rejection of the previous picture in temporal antialiasing.
#include <algorithm>
#include <limits>

#include <gtest/gtest.h>

#include "denoise/stages/antialias_shared.h"
#include "denoise/test_frames.h"
#include "stillray/denoise.hpp"

namespace stillray::antialias_test {
namespace {

using test::FillImage;
using test::Light;
using test::MakeWall;

/// A wall under light that differs from pixel to pixel, so that the clamp lets much pass.
Frame MakeStripes(int64_t index, float brightness) {
  Frame f = MakeWall(32, 24, index);
  FillImage<3>(&Light(&f, SignalKind::kDirectDiffuse),
               [&](int x, int y, int) { return brightness * ((x + y) % 2 == 0 ? 0.1f : 1.0f); });
  return f;
}

TEST(Antialias, NewPictureWeight) {
  EXPECT_FLOAT_EQ(NewPictureWeight(0.1f, 1, 1), 1.0f);   // the first sample of a surface
  EXPECT_FLOAT_EQ(NewPictureWeight(0.1f, 4, 1), 0.25f);  // a plain mean while it is young
  EXPECT_FLOAT_EQ(NewPictureWeight(0.1f, 4, 4), 1.0f);
  EXPECT_FLOAT_EQ(NewPictureWeight(0.1f, 16, 4), 1.0f / 7);    // 2 of 2 + 12
  EXPECT_FLOAT_EQ(NewPictureWeight(0.1f, 128, 64), 1.0f / 9);  // 8 of 8 + 64
  EXPECT_FLOAT_EQ(NewPictureWeight(0.1f, 200, 1), 0.1f);       // then the requested weight
  EXPECT_FLOAT_EQ(NewPictureWeight(0.1f, 0.5f, 0), 0.1f);      // without new samples: unchanged
  EXPECT_FLOAT_EQ(NewPictureWeight(0.1f, 0.25f, 0.5f), 1.0f);  // never more than all
}

TEST(Antialias, MovingAlpha) {
  EXPECT_EQ(MovingAlpha(0.12f, 0.28f, vec2(0.0f), 1), 0.12f);
  EXPECT_FLOAT_EQ(MovingAlpha(0.12f, 0.28f, vec2(0.125f, 0.0f), 1), 0.2f);  // in part
  EXPECT_FLOAT_EQ(MovingAlpha(0.12f, 0.28f, vec2(0.0f, -0.25f), 1), 0.28f);
  EXPECT_FLOAT_EQ(MovingAlpha(0.12f, 0.28f, vec2(-7.0f, 3.0f), 1), 0.28f);
  EXPECT_FLOAT_EQ(MovingAlpha(0.12f, 0.28f, vec2(-7.0f, 3.0f), 0.25f), 0.16f);
  EXPECT_EQ(MovingAlpha(0.12f, 0.28f, vec2(9.0f), 0), 0.12f);
  EXPECT_EQ(MovingAlpha(0.5f, 0.28f, vec2(9.0f), 1), 0.5f);  // never less than requested
}

TEST(Antialias, AlbedoAgreement) {
  EXPECT_EQ(AlbedoAgreement(0.5f, 0.5f), 1.0f);
  EXPECT_EQ(AlbedoAgreement(0.0f, 0.0f), 1.0f);
  EXPECT_NEAR(AlbedoAgreement(0.7f, 0.8f), 1 - 0.5 * 0.8 / 0.802,
              1e-6);  // half of a quarter of 0.8
  EXPECT_NEAR(AlbedoAgreement(0.8f, 0.7f), 1 - 0.5 * 0.8 / 0.802, 1e-6);
  EXPECT_EQ(AlbedoAgreement(0.8f, 0.5f), 0.0f);
  EXPECT_EQ(AlbedoAgreement(0.0f, 1.0f), 0.0f);
}

TEST(Antialias, NewPicturesCountMoreWhereThePictureMoves) {
  Settings s = PresetSettings("default").value();
  s.wavelet = Wavelet::kOff;
  s.antialias = Antialias::kTaa;
  s.taa_alpha = 0.1f;
  s.taa_moving_alpha = 0.4f;
  s.alpha_min = s.alpha_moments = 1;  // "aliased" is the light of the frame
  s.taa_follow_light = false;
  s.limit_history = false;
  for (const Backend backend : {Backend::kReference, Backend::kCpu}) {
    Denoiser d = Denoiser::Create(s, backend).value();
    ASSERT_TRUE(d.SetOutputs({"aliased"}).ok());
    DenoisedFrame out;
    for (int i = 0; i < 40; ++i) {
      ASSERT_TRUE(d.Denoise(MakeStripes(i, 1.0f), &out).ok());
    }
    const Image3 before = out.colour;
    // The stripes change places. The lower half moves by whole pixels, at which nothing is
    // interpolated.
    Frame next = MakeStripes(40, 1.0f);
    FillImage<3>(&Light(&next, SignalKind::kDirectDiffuse),
                 [](int x, int y, int) { return (x + y) % 2 == 0 ? 1.0f : 0.1f; });
    FillImage<2>(&next.guides.motion,
                 [](int, int y, int c) { return y >= 12 && c == 0 ? 2.0f : 0.0f; });
    ASSERT_TRUE(d.Denoise(next, &out).ok());
    const Image1& aliased = out.images[0].channels[1];
    for (int y = 2; y < 22; ++y) {
      for (int x = 2; x < 28; ++x) {
        const float old = before[1](y < 12 ? x : x + 2, y);
        const float alpha = y < 12 ? 0.1f : 0.4f;
        EXPECT_GT(std::abs(aliased(x, y) - old), 0.3f);
        EXPECT_NEAR(out.colour[1](x, y), old + alpha * (aliased(x, y) - old), 1e-5f)
            << x << " " << y;
      }
    }
  }
}

TEST(Antialias, TonemappedBlendIsTheInverseCurveOfTheBlendOfCurves) {
  for (const double scale : {0.25, 1.0, 8.0}) {
    const auto curve = [&](double x) { return scale * x / (1 + scale * x); };
    for (const float before : {0.0f, 0.01f, 1.0f, 700.0f}) {
      for (const float now : {0.0f, 0.3f, 5.0f, 40000.0f}) {
        for (const float alpha : {0.0f, 0.12f, 0.5f, 1.0f}) {
          const double y = (1.0 - alpha) * curve(before) + static_cast<double>(alpha) * curve(now);
          const double expected = y / (scale * (1 - y));
          EXPECT_NEAR(BlendTonemapped(before, now, alpha, static_cast<float>(scale)), expected,
                      2e-6 * expected)
              << before << " " << now << " " << alpha << " " << scale;
        }
      }
    }
  }
}

TEST(Antialias, TheEdgeOfALampIsSmoothUnderTheToneCurve) {
  // A lamp of luminance 60 covers a pixel in every second frame. Half covered the pixel is mid grey
  // on a display; a mean of linear light is as white as the lamp.
  const auto pixel = [](const char* tonemapped) {
    Settings s = PresetSettings("svgf").value();
    s.wavelet = Wavelet::kOff;
    s.temporal = false;
    s.antialias = Antialias::kTaa;
    s.taa_alpha = 0.02f;
    EXPECT_TRUE(SetParameter(&s, "taa_tonemapped", tonemapped).ok());
    Denoiser d = Denoiser::Create(s).value();
    DenoisedFrame out;
    for (int i = 0; i < 400; ++i) {
      Frame f = MakeWall(16, 8, i);
      for (Signal& signal : f.signals) {
        signal.radiance = Image3(16, 8);
      }
      for (int y = 0; y < 8; ++y) {
        for (int x = 0; x < 16; ++x) {
          for (int c = 0; c < 3; ++c) {
            f.emission[c](x, y) = x < 8 + i % 2 ? 60.0f : 0.0f;
          }
        }
      }
      EXPECT_TRUE(d.Denoise(f, &out).ok());
    }
    return out.colour[1](8, 4);
  };
  const float half_of_curve = 60.0f / 61.0f / 2;
  EXPECT_NEAR(pixel("on"), half_of_curve / (1 - half_of_curve), 0.03f);
  EXPECT_NEAR(pixel("off"), 30.0f, 1.0f);
}

TEST(Antialias, APictureOfAnotherSurfaceIsForgotten) {
  Settings s = PresetSettings("default").value();
  s.wavelet = Wavelet::kOff;
  s.antialias = Antialias::kTaa;
  for (const Backend backend : {Backend::kReference, Backend::kCpu}) {
    Denoiser d = Denoiser::Create(s, backend).value();
    ASSERT_TRUE(d.SetOutputs({"aliased"}).ok());
    DenoisedFrame out;
    for (int i = 0; i < 6; ++i) {
      ASSERT_TRUE(d.Denoise(MakeStripes(i, 1.0f), &out).ok());
    }
    Frame other = MakeStripes(6, 2.0f);
    other.guides.id.Fill(9);
    for (Signal& signal : other.signals) {
      std::swap(signal.radiance[0], signal.radiance[1]);
    }
    ASSERT_TRUE(d.Denoise(other, &out).ok());
    for (int y = 0; y < 24; ++y) {
      for (int x = 0; x < 32; ++x) {
        EXPECT_FLOAT_EQ(out.colour[1](x, y), out.images[0].channels[1](x, y)) << x << " " << y;
      }
    }
  }
}

// The previous picture holds the light of the last frame: it counts no more than that does.
TEST(Antialias, APictureOfLightThatHoldsNoMoreCountsLess) {
  constexpr float kAlpha = 0.1f;
  Settings s = PresetSettings("default").value();
  s.wavelet = Wavelet::kOff;
  s.antialias = Antialias::kTaa;
  s.taa_alpha = kAlpha;
  s.taa_follow_light = false;
  s.limit_history = false;
  for (const Backend backend : {Backend::kReference, Backend::kCpu}) {
    Denoiser d = Denoiser::Create(s, backend).value();
    ASSERT_TRUE(d.SetOutputs({"aliased"}).ok());
    DenoisedFrame out;
    for (int i = 0; i < 40; ++i) {
      ASSERT_TRUE(d.Denoise(MakeStripes(i, 1.0f), &out).ok());
    }
    const Image3 before = out.colour;
    Frame next = MakeStripes(40, 1.0f);
    for (Signal& signal : next.signals) {
      for (int y = 0; y < 24; ++y) {
        for (int x = 0; x < 32; ++x) {
          signal.radiance[1](x, y) = (x + y) % 2 == 0 ? 1.0f : 0.1f;  // stripes change places
        }
      }
    }
    next.confidence = Image1(32, 24);
    FillImage(&next.confidence, [](int x, int) {
      return x < 10 ? 0.0f : x < 20 ? 0.5f : std::numeric_limits<float>::quiet_NaN();
    });
    ASSERT_TRUE(d.Denoise(next, &out).ok());
    const Image1& aliased = out.images[0].channels[1];
    for (int y = 2; y < 22; ++y) {
      for (int x = 2; x < 30; ++x) {
        float low = aliased(x, y);
        float high = low;
        for (int i = 0; i < 9; ++i) {
          low = std::min(low, aliased(x - 1 + i % 3, y - 1 + i / 3));
          high = std::max(high, aliased(x - 1 + i % 3, y - 1 + i / 3));
        }
        const float kept = std::clamp(before[1](x, y), low, high);
        // Of weights (1 - alpha) c to alpha, c = 0, 0.5 and 1.
        const float alpha = x < 10 ? 1.0f : x < 20 ? kAlpha / (kAlpha + 0.45f) : kAlpha;
        EXPECT_NEAR(out.colour[1](x, y), kept + alpha * (aliased(x, y) - kept), 1e-5f)
            << x << " " << y;
      }
    }
  }
}

TEST(Antialias, AThinDisocclusionIsStillAntialiased) {
  // Jitter uncovers and covers edges all the time: a pixel whose neighbours have a history keeps
  // blending, or edges would never be smooth.
  Settings s = PresetSettings("default").value();
  s.wavelet = Wavelet::kOff;
  s.antialias = Antialias::kTaa;
  s.history_search = false;
  Denoiser d = Denoiser::Create(s).value();
  ASSERT_TRUE(d.SetOutputs({"aliased"}).ok());
  DenoisedFrame out;
  for (int i = 0; i < 10; ++i) {
    ASSERT_TRUE(d.Denoise(MakeStripes(i, 1.0f), &out).ok());
  }
  Frame f = MakeStripes(10, 1.0f);
  for (int y = 0; y < 24; ++y) {
    f.guides.id(16, y) = 2;
    for (int c = 0; c < 3; ++c) {
      Light(&f, SignalKind::kDirectDiffuse)[c](16, y) = 2.0f;
    }
  }
  ASSERT_TRUE(d.Denoise(f, &out).ok());
  const float aliased = out.images[0].channels[0](16, 12);
  EXPECT_FLOAT_EQ(aliased, 2.0f);
  EXPECT_LT(out.colour[0](16, 12), 0.7f * aliased);
}

}  // namespace
}  // namespace stillray::antialias_test
