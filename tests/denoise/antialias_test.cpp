// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Rejection of the previous picture in temporal antialiasing.
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

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

/// Of `default`, without the stages between accumulation and antialiasing.
Settings UnfilteredSettings(float taa_alpha) {
  Settings s = PresetSettings("default").value();
  s.wavelet = Wavelet::kOff;
  s.antialias = Antialias::kTaa;
  s.taa_alpha = taa_alpha;
  s.taa_follow_light = false;
  s.limit_history = false;
  return s;
}

/// Denoises the first 40 frames of MakeStripes, with the output "aliased".
void DenoiseFortyStripes(Denoiser* d, DenoisedFrame* out) {
  ASSERT_TRUE(d->SetOutputs({"aliased"}).ok());
  for (int i = 0; i < 40; ++i) {
    ASSERT_TRUE(d->Denoise(MakeStripes(i, 1.0f), out).ok());
  }
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

/// Integral of a pixel over a part of it, from and to in 0..1: of the step between the neighbours'
/// values whose mean is the pixel's own value, or of a constant.
double PartOfPixel(double before, double own, double after, double from, double to) {
  if ((own - before) * (after - own) < 0 || before == after) {
    return own * (to - from);
  }
  const double step = (after - own) / (after - before);  // where the value of `after` begins
  const double of_before = std::clamp(step, from, to) - from;
  return before * of_before + after * (to - from - of_before);
}

TEST(Antialias, SubcellRowsAreIntegralsOfStepsAndASpline) {
  for (uint32_t i = 0; i < 2000; ++i) {
    float v[4];
    for (uint32_t k = 0; k < 4; ++k) {
      v[k] = std::floor(8 * test::Random(i, k, 1u)) * (i % 2 == 0 ? 0.25f : 40.0f) - 1.0f;
    }
    const float t = i % 7 == 0 ? 0.0f : test::Random(i, 4u, 1u);
    const double steps = PartOfPixel(v[0], v[1], v[2], t, 1) + PartOfPixel(v[1], v[2], v[3], 0, t);
    const vec4 w = CatmullRom(t);
    double cubic = 0;
    for (int k = 0; k < 4; ++k) {
      cubic += static_cast<double>(w[k]) * static_cast<double>(v[k]);
    }
    const double expected = 0.75 * steps + 0.25 * cubic;
    EXPECT_NEAR(ResampleSubcell(v[0], v[1], v[2], v[3], t), expected,
                2e-6 * (1 + std::abs(expected) + std::abs(v[1])))
        << i;
  }
}

TEST(Antialias, SubcellKeepsConstantsAndGradients) {
  for (const float t : {0.0f, 0.1f, 0.5f, 0.8f, 1.0f}) {
    EXPECT_EQ(ResampleSubcell(7, 7, 7, 7, t), 7.0f);
    EXPECT_FLOAT_EQ(ResampleSubcell(1, 2, 3, 4, t), 2 + t);
    EXPECT_FLOAT_EQ(ResampleSubcell(9, 6, 3, 0, t), 6 - 3 * t);
  }
  EXPECT_EQ(ResampleSubcell(3, -8, 5, 1, 0), -8.0f);
  EXPECT_EQ(ResampleSubcell(3, -8, 5, 1, 1), 5.0f);
}

TEST(Antialias, SubcellKeepsEdgesWithinAPixel) {
  constexpr int kPixels = 64;
  const auto moved = [](const auto& resample) {
    const auto covered = [](int x, double edge) { return std::clamp(x + 0.5 - edge, 0.0, 1.0); };
    double edge = 50.3;
    std::vector<float> row(kPixels);
    for (int x = 0; x < kPixels; ++x) {
      row[static_cast<size_t>(x)] = static_cast<float>(covered(x, edge));
    }
    for (int i = 0; i < 10; ++i) {  // about as many as a picture holds
      std::vector<float> next(kPixels);
      for (int x = 0; x < kPixels; ++x) {
        const auto tap = [&](int k) {
          return row[static_cast<size_t>(std::clamp(x + k, 0, kPixels - 1))];
        };
        next[static_cast<size_t>(x)] = resample(tap(-1), tap(0), tap(1), tap(2), 0.45f);
      }
      row = next;
      edge -= 0.45;
    }
    double error = 0;
    for (int x = 0; x < kPixels; ++x) {
      error += std::abs(static_cast<double>(row[static_cast<size_t>(x)]) - covered(x, edge));
    }
    return error;
  };
  const double cubic = moved([](float a, float b, float c, float d, float t) {
    const vec4 w = CatmullRom(t);
    return w.x * a + w.y * b + w.z * c + w.w * d;
  });
  const double subcell = moved(
      [](float a, float b, float c, float d, float t) { return ResampleSubcell(a, b, c, d, t); });
  EXPECT_GT(cubic, 0.5);
  EXPECT_LT(subcell, 0.35 * cubic);
}

TEST(Antialias, ExtrapolatedMotion) {
  const auto expect = [](vec2 found, float x, float y) {
    EXPECT_FLOAT_EQ(found.x, x);
    EXPECT_FLOAT_EQ(found.y, y);
  };
  const vec2 m(3.0f, -1.0f);
  expect(ExtrapolatedMotion(m, vec2(2.75f, -1.125f), vec2(2.5f, -1.25f)), 3.25f, -0.875f);
  expect(ExtrapolatedMotion(m, vec2(2.75f, -1.0f), vec2(2.4f, -1.1f)), 3.25f,
         -1.0f);  // bends a little
  expect(ExtrapolatedMotion(m, m, m), 3.0f, -1.0f);
  // Moves apart, and more than a little bend along an axis.
  expect(ExtrapolatedMotion(m, vec2(2.5f, -1.0f), vec2(2.0f, -1.0f)), 3.0f, -1.0f);
  expect(ExtrapolatedMotion(m, vec2(2.75f, -1.0f), vec2(2.75f, -1.0f)), 3.0f, -1.0f);
  expect(ExtrapolatedMotion(m, vec2(2.75f, -1.0f), vec2(2.5f, -1.2f)), 3.0f, -1.0f);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  expect(ExtrapolatedMotion(m, vec2(nan, -1.0f), vec2(2.5f, -1.0f)), 3.0f, -1.0f);
  expect(ExtrapolatedMotion(m, vec2(2.75f, -1.0f), vec2(2.5f, nan)), 3.0f, -1.0f);
}

// The picture is a gradient, so that it shows the motion along which it was fetched.
TEST(Antialias, SilhouettesMoveAsTheSurfaceInFront) {
  constexpr int kEdge = 10;  // the first pixel of the wall behind
  const auto followed = [](Backend backend, bool extrapolates, int thickness, float broken) {
    Settings s = PresetSettings("svgf").value();
    s.wavelet = Wavelet::kOff;
    s.temporal = false;
    s.antialias = Antialias::kTaa;
    s.taa_alpha = 0.5f;
    s.taa_extrapolate_motion = extrapolates;
    Denoiser d = Denoiser::Create(s, backend).value();
    DenoisedFrame out;
    for (int i = 0; i < 2; ++i) {
      Frame f = MakeWall(24, 8, i);
      FillImage<3>(&f.emission, [](int x, int, int) { return 0.1f * static_cast<float>(x); });
      for (int y = 0; y < 8; ++y) {
        for (int x = kEdge - thickness; x < kEdge; ++x) {
          f.guides.depth(x, y) = 2;
          f.guides.id(x, y) = 2;
          f.guides.motion[0](x, y) = 0.2f + 0.05f * static_cast<float>(x);
        }
        f.guides.motion[0](kEdge - 2, y) += broken;
      }
      EXPECT_TRUE(d.Denoise(f, &out).ok());
    }
    return (out.colour[1](kEdge, 4) - 0.1f * kEdge) / 0.05f;
  };
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (const Backend backend : {Backend::kReference, Backend::kCpu}) {
    EXPECT_NEAR(followed(backend, false, 6, 0), 0.65f, 1e-4f);  // of the neighbour
    EXPECT_NEAR(followed(backend, true, 6, 0), 0.7f, 1e-4f);    // continued
    EXPECT_NEAR(followed(backend, true, 6, nan), 0.65f, 1e-4f);
    EXPECT_NEAR(followed(backend, true, 3, 0), 0.7f, 1e-4f);
    EXPECT_NEAR(followed(backend, true, 2, 0), 0.65f, 1e-4f);      // too thin
    EXPECT_NEAR(followed(backend, true, 6, -0.2f), 0.65f, 1e-4f);  // another motion, as of an image
  }
}

TEST(Antialias, NewPicturesCountMoreWhereThePictureMoves) {
  Settings s = UnfilteredSettings(0.1f);
  s.taa_moving_alpha = 0.4f;
  s.alpha_min = s.alpha_moments = 1;  // "aliased" is the light of the frame
  for (const Backend backend : {Backend::kReference, Backend::kCpu}) {
    Denoiser d = Denoiser::Create(s, backend).value();
    DenoisedFrame out;
    DenoiseFortyStripes(&d, &out);
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
  const Settings s = UnfilteredSettings(kAlpha);
  for (const Backend backend : {Backend::kReference, Backend::kCpu}) {
    Denoiser d = Denoiser::Create(s, backend).value();
    DenoisedFrame out;
    DenoiseFortyStripes(&d, &out);
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
