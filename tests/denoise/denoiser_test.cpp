// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The pipeline as a whole: what must be true whatever the settings, and that the vector version on
// every instruction set gives the pictures of the scalar reference.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <hwy/targets.h>
#include <oneapi/tbb/global_control.h>

#include <cmath>
#include <string>

#include "denoise/test_frames.h"
#include "stillray/denoise.hpp"

namespace stillray {
namespace {

using test::FillImage;
using test::Light;
using test::MakeBusyFrame;
using test::MakeWall;
using test::SameBits;
using ::testing::HasSubstr;

Denoiser MakeDenoiser(const Settings& s, Backend backend = Backend::kCpu) {
  Result<Denoiser> made = Denoiser::Create(s, backend);
  EXPECT_TRUE(made.ok()) << made.status().message();
  return std::move(made.value());
}

/// Largest difference relative to the brighter of the two plus a little.
double LargestError(const Image3& a, const Image3& b) {
  double worst = 0;
  for (int c = 0; c < 3; ++c) {
    for (int y = 0; y < a.height(); ++y) {
      for (int x = 0; x < a.width(); ++x) {
        const double scale = std::max({std::abs(a[c](x, y)), std::abs(b[c](x, y)), 0.05f});
        const double error = std::abs(a[c](x, y) - b[c](x, y)) / scale;
        worst = std::isnan(error) ? 1e30 : std::max(worst, error);
      }
    }
  }
  return worst;
}

/// Root of the mean squared difference over the root mean square of \p b.
double RmsError(const Image3& a, const Image3& b) {
  double error = 0;
  double square = 0;
  for (int c = 0; c < 3; ++c) {
    for (int y = 0; y < a.height(); ++y) {
      for (int x = 0; x < a.width(); ++x) {
        const double d = static_cast<double>(a[c](x, y)) - b[c](x, y);
        error += d * d;
        square += static_cast<double>(b[c](x, y)) * b[c](x, y);
      }
    }
  }
  return std::sqrt(error / square);
}

std::vector<Settings> AllKindsOfSettings() {
  std::vector<Settings> all;
  for (const std::string_view preset : PresetNames()) {
    all.push_back(PresetSettings(preset).value());
    // Decides at thresholds, so that a rounding may change a pixel; one code serves both versions.
    all.back().fxaa = Fxaa::kOff;
  }
  const auto add = [&](std::string_view preset,
                       std::initializer_list<std::pair<const char*, const char*>> changes) {
    Settings s = PresetSettings(preset).value();
    s.fxaa = Fxaa::kOff;
    for (const auto& [name, value] : changes) {
      EXPECT_TRUE(SetParameter(&s, name, value).ok());
    }
    all.push_back(s);
  };
  add("default", {{"wavelet", "naive"}});
  add("default",
      {{"kernel", "3x3"}, {"depth_weight", "gradient"}, {"max_slope", "0.01"}, {"feedback", "2"}});
  add("default",
      {{"short_history", "blur"}, {"luminance", "rec601"}, {"luminance_scale", "variance"}});
  add("default", {{"signals", "single"}, {"demodulate", "off"}, {"firefly", "clamp"}});
  add("svgf", {{"firefly", "compress"},
               {"wavelet_id", "on"},
               {"steps", "4,2,1"},
               {"prefilter_variance", "off"}});
  add("default",
      {{"signals", "diffuse_specular"}, {"history_search", "off"}, {"max_history", "5"}});
  return all;
}

TEST(Denoiser, VectorVersionMatchesReferenceOnEveryTarget) {
  // Both differ in rounding and in the approximated exponentials (3e-7 each). That grows where a
  // luminance weight divides by a deviation near zero, and over frames with feedback; a difference
  // at a threshold (a tap accepted by one, not the other) would be far larger still.
  constexpr double kTolerance = 1e-2;
  constexpr double kRmsTolerance = 1e-4;
  for (const Settings& s : AllKindsOfSettings()) {
    const int width = 67;
    const int height = 35;
    Denoiser reference = MakeDenoiser(s, Backend::kReference);
    std::vector<Image3> expected;
    for (int i = 0; i < 7; ++i) {
      DenoisedFrame out;
      ASSERT_TRUE(reference.Denoise(MakeBusyFrame(width, height, i), &out).ok());
      expected.push_back(out.colour);
    }
    for (int64_t targets = hwy::SupportedTargets(); targets != 0; targets &= targets - 1) {
      hwy::SetSupportedTargetsForTest(targets & -targets);
      Denoiser cpu = MakeDenoiser(s);
      for (int i = 0; i < 7; ++i) {
        DenoisedFrame out;
        ASSERT_TRUE(cpu.Denoise(MakeBusyFrame(width, height, i), &out).ok());
        const Image3& reference_colour = expected[static_cast<size_t>(i)];
        EXPECT_LT(RmsError(out.colour, reference_colour), kRmsTolerance) << "frame " << i;
        EXPECT_LT(LargestError(out.colour, reference_colour), kTolerance)
            << "frame " << i << " target " << hwy::TargetName(targets & -targets) << " wavelet "
            << GetParameter(s, "wavelet").value() << " signals "
            << GetParameter(s, "signals").value();
      }
    }
    hwy::SetSupportedTargetsForTest(0);
  }
}

TEST(Denoiser, ConstantLightStaysConstant) {
  for (Settings s : AllKindsOfSettings()) {
    for (const Backend backend : {Backend::kReference, Backend::kCpu}) {
      Denoiser d = MakeDenoiser(s, backend);
      DenoisedFrame out;
      for (int i = 0; i < 6; ++i) {
        Frame f = MakeWall(33, 21, i);
        FillImage<3>(&Light(&f, SignalKind::kDirectDiffuse),
                     [](int, int, int c) { return 0.25f * static_cast<float>(c + 1); });
        f.guides.motion[0].Fill(0.3f);
        ASSERT_TRUE(d.Denoise(f, &out).ok());
        for (int c = 0; c < 3; ++c) {
          for (int x = 0; x < 33; ++x) {
            EXPECT_NEAR(out.colour[c](x, 10), 0.25f * static_cast<float>(c + 1), 1e-5f);
          }
        }
      }
    }
  }
}

TEST(Denoiser, NothingLeaksAcrossAnEdge) {
  // Left half lit and noisy, right half black: differently oriented, at another depth, another id.
  for (const char* preset : {"default", "svgf", "eaw"}) {
    Denoiser d = MakeDenoiser(PresetSettings(preset).value());
    DenoisedFrame out;
    for (int i = 0; i < 8; ++i) {
      Frame f = MakeWall(64, 32, i);
      for (int y = 0; y < 32; ++y) {
        for (int x = 32; x < 64; ++x) {
          f.guides.normal[0](x, y) = 1;
          f.guides.normal[2](x, y) = 0;
          f.guides.depth(x, y) = 9;
          f.guides.id(x, y) = 2;
        }
      }
      FillImage<3>(&Light(&f, SignalKind::kDirectDiffuse), [&](int x, int y, int) {
        return x < 32 ? 4.0f * test::Random(static_cast<uint32_t>(i), static_cast<uint32_t>(x),
                                            static_cast<uint32_t>(y))
                      : 0.0f;
      });
      ASSERT_TRUE(d.Denoise(f, &out).ok());
    }
    double right = 0;
    for (int y = 0; y < 32; ++y) {
      for (int x = 33; x < 64; ++x) {
        right = std::max<double>(right, out.colour[0](x, y));
      }
    }
    EXPECT_LT(right, 1e-4) << preset;
  }
}

TEST(Denoiser, NoiseFallsAndMeanIsKept) {
  const auto run = [](const Settings& s, double* mean) {
    Denoiser d = MakeDenoiser(s);
    DenoisedFrame out;
    for (int i = 0; i < 24; ++i) {
      Frame f = MakeWall(96, 64, i);
      FillImage<3>(&Light(&f, SignalKind::kDirectDiffuse), [&](int x, int y, int) {
        // Sparse light of mean 0.5: 0 or 2.
        return test::Random(static_cast<uint32_t>(i), static_cast<uint32_t>(x),
                            static_cast<uint32_t>(y)) < 0.25f
                   ? 2.0f
                   : 0.0f;
      });
      EXPECT_TRUE(d.Denoise(f, &out).ok());
    }
    double sum = 0;
    double sum2 = 0;
    for (int y = 0; y < 64; ++y) {
      for (int x = 0; x < 96; ++x) {
        sum += out.colour[0](x, y);
        sum2 += out.colour[0](x, y) * out.colour[0](x, y);
      }
    }
    *mean = sum / (96 * 64);
    return std::sqrt(sum2 / (96 * 64) - *mean * *mean);
  };
  double mean = 0;
  Settings temporal = PresetSettings("temporal").value();
  temporal.antialias = Antialias::kOff;
  const double accumulated = run(temporal, &mean);
  EXPECT_NEAR(mean, 0.5, 0.005);
  // alpha 0.1: an exponential mean of 19 effective frames of deviation 0.866, nearly settled after
  // 24 frames.
  EXPECT_NEAR(accumulated, 0.866 * std::sqrt(0.1 / 1.9), 0.02);
  for (const char* preset : {"default", "svgf"}) {
    Settings s = PresetSettings(preset).value();
    s.antialias = Antialias::kOff;
    const double denoised = run(s, &mean);
    EXPECT_LT(denoised, accumulated / 4) << preset;
    // SVGF measures differences in the pixel's own noise and so turns bright neighbours away (see
    // SharedStop): a known darkening, which "default" nearly avoids.
    EXPECT_NEAR(mean, 0.5, std::string_view(preset) == "svgf" ? 0.02 : 0.006) << preset;
  }
}

TEST(Denoiser, TwiceTheLightGivesTwiceThePicture) {
  for (const char* preset : {"default", "svgf", "eaw", "temporal"}) {
    Denoiser once = MakeDenoiser(PresetSettings(preset).value());
    Denoiser twice = MakeDenoiser(PresetSettings(preset).value());
    DenoisedFrame a;
    DenoisedFrame b;
    for (int i = 0; i < 6; ++i) {
      Frame f = MakeBusyFrame(48, 32, i);
      ASSERT_TRUE(once.Denoise(f, &a).ok());
      const auto scale = [](Image3* image) {
        const Image3 copy = *image;
        FillImage<3>(image, [&](int x, int y, int c) { return 1024.0f * copy[c](x, y); });
      };
      for (Signal& s : f.signals) {
        scale(&s.radiance);
      }
      scale(&f.background);
      ASSERT_TRUE(twice.Denoise(f, &b).ok());
      FillImage<3>(&a.colour,
                   [copy = a.colour](int x, int y, int c) { return 1024.0f * copy[c](x, y); });
      EXPECT_LT(LargestError(a.colour, b.colour), 1e-4) << preset << " frame " << i;
    }
  }
}

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

TEST(Denoiser, ThreadsDoNotChangeBits) {
  const Settings s = PresetSettings("default").value();
  std::vector<Image3> first;
  for (const int threads : {1, 2, 3}) {
    tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                              static_cast<size_t>(threads));
    Denoiser d = MakeDenoiser(s);
    for (int i = 0; i < 5; ++i) {
      DenoisedFrame out;
      ASSERT_TRUE(d.Denoise(MakeBusyFrame(80, 61, i), &out).ok());
      if (threads == 1) {
        first.push_back(out.colour);
      } else {
        EXPECT_TRUE(SameBits(out.colour, first[static_cast<size_t>(i)]));
      }
    }
  }
}

TEST(Denoiser, SavedHistoryContinuesWithTheSameBits) {
  for (const char* preset : {"default", "svgf"}) {
    const Settings s = PresetSettings(preset).value();
    Denoiser whole = MakeDenoiser(s);
    DenoisedFrame expected;
    std::vector<uint8_t> saved;
    for (int i = 0; i < 6; ++i) {
      ASSERT_TRUE(whole.Denoise(MakeBusyFrame(40, 30, i), &expected).ok());
      if (i == 2) {
        saved = whole.SaveHistory().value();
      }
    }
    Denoiser resumed = MakeDenoiser(s);
    ASSERT_TRUE(resumed.RestoreHistory(saved).ok());
    DenoisedFrame out;
    for (int i = 3; i < 6; ++i) {
      ASSERT_TRUE(resumed.Denoise(MakeBusyFrame(40, 30, i), &out).ok());
    }
    EXPECT_TRUE(SameBits(out.colour, expected.colour)) << preset;
    EXPECT_EQ(resumed.SaveHistory().value(), whole.SaveHistory().value());
  }
}

TEST(Denoiser, DamagedHistoryIsRefused) {
  Denoiser d = MakeDenoiser(PresetSettings("default").value());
  DenoisedFrame out;
  ASSERT_TRUE(d.Denoise(MakeBusyFrame(16, 16, 0), &out).ok());
  std::vector<uint8_t> saved = d.SaveHistory().value();
  EXPECT_TRUE(d.RestoreHistory(saved).ok());
  EXPECT_EQ(d.RestoreHistory(std::span(saved).first(10)).code(), StatusCode::kBadData);
  EXPECT_EQ(d.RestoreHistory(std::span(saved).first(saved.size() - 1)).code(),
            StatusCode::kBadData);
  Denoiser other = MakeDenoiser(PresetSettings("svgf").value());
  EXPECT_THAT(other.RestoreHistory(saved).message(),
              HasSubstr("made with limit_history on, the settings have it off"));
  Settings single;
  single.signals = SignalGrouping::kSingle;
  EXPECT_THAT(MakeDenoiser(single).RestoreHistory(saved).message(),
              HasSubstr("3 signals, the settings ask for 1"));
  saved[0] = 'x';
  EXPECT_EQ(d.RestoreHistory(saved).code(), StatusCode::kBadData);
}

TEST(Denoiser, HistoryLengthOfAStillView) {
  Settings s = PresetSettings("default").value();
  s.limit_history = false;
  Denoiser d = MakeDenoiser(s);
  ASSERT_TRUE(d.SetOutputs({"history"}).ok());
  DenoisedFrame out;
  for (int i = 1; i <= 20; ++i) {
    ASSERT_TRUE(d.Denoise(MakeWall(20, 20, i), &out).ok());
    ASSERT_EQ(out.images.size(), 3u);
    EXPECT_EQ(out.images[0].name, "history.direct");
    EXPECT_EQ(out.images[0].channels[0](7, 7), static_cast<float>(i));
  }
  d.Reset();
  ASSERT_TRUE(d.Denoise(MakeWall(20, 20, 21), &out).ok());
  EXPECT_EQ(out.images[0].channels[0](7, 7), 1.0f);
}

TEST(Denoiser, DisocclusionMaskOfAMovingQuadIsExact) {
  // A quad of 12x10 pixels moves right by 3 pixels per frame in front of a wall: what it uncovers
  // is a strip of 3x10 pixels at its left, no pixel more, no pixel less.
  Settings s = PresetSettings("default").value();
  s.history_search = false;
  for (const Backend backend : {Backend::kReference, Backend::kCpu}) {
    Denoiser d = MakeDenoiser(s, backend);
    ASSERT_TRUE(d.SetOutputs({"disocclusion"}).ok());
    DenoisedFrame out;
    for (int i = 0; i < 5; ++i) {
      Frame f = MakeWall(64, 32, i);
      const int left = 10 + 3 * i;
      for (int y = 8; y < 18; ++y) {
        for (int x = left; x < left + 12; ++x) {
          f.guides.depth(x, y) = 3;
          f.guides.id(x, y) = 2;
          f.guides.motion[0](x, y) = -3;
        }
      }
      ASSERT_TRUE(d.Denoise(f, &out).ok());
      for (int y = 0; y < 32; ++y) {
        for (int x = 0; x < 64; ++x) {
          const bool uncovered = i > 0 && y >= 8 && y < 18 && x >= left - 3 && x < left;
          EXPECT_EQ(out.images[0].channels[0](x, y), uncovered || i == 0 ? 1.0f : 0.0f)
              << i << ": " << x << " " << y;
        }
      }
    }
  }
}

TEST(Denoiser, ReprojectionIsExactToAHundredthOfAPixel) {
  // A picture painted on a wall, seen sharp in the first frame; in the second no light arrives, so
  // that the history alone shows. A straight ramp turns places into values without error.
  constexpr float kMotionX = 1.37f;
  constexpr float kMotionY = -2.61f;
  const auto paint = [](double x, double y) { return 1 + 0.05 * x + 0.03 * y; };
  Denoiser d = MakeDenoiser(PresetSettings("temporal").value());
  ASSERT_TRUE(d.SetOutputs({"accumulated"}).ok());
  DenoisedFrame out;
  for (int i = 0; i < 2; ++i) {
    Frame f = MakeWall(48, 32, i);
    f.guides.motion[0].Fill(kMotionX);
    f.guides.motion[1].Fill(kMotionY);
    FillImage<3>(&Light(&f, SignalKind::kDirectDiffuse),
                 [&](int x, int y, int) { return static_cast<float>(paint(x, y)); });
    f.samples = Image1(48, 32);
    f.samples.Fill(i == 0 ? 1.0f : 0.0f);
    ASSERT_TRUE(d.Denoise(f, &out).ok());
  }
  for (const NamedImage& image : out.images) {
    if (image.name != "accumulated.direct") {
      continue;
    }
    for (int y = 4; y < 30; ++y) {
      for (int x = 2; x < 44; ++x) {
        const double albedo = 0.5;  // of the wall
        EXPECT_NEAR(image.channels[0](x, y) * albedo,
                    paint(x + static_cast<double>(kMotionX), y + static_cast<double>(kMotionY)),
                    0.01 * 0.03);
      }
    }
    return;
  }
  FAIL() << "no such output";
}

TEST(Denoiser, TransmissionIsASignalOfItsOwn) {
  // What is reflected and what is seen through the glass, each with its own albedo, add up again.
  const auto make = [](int i) {
    Frame f = MakeWall(32, 24, i);
    f.signals.push_back({SignalKind::kDirectTransmission, Image3(32, 24), Image1()});
    f.guides.transmission_albedo = Image3(32, 24);
    FillImage<3>(&f.guides.transmission_albedo,
                 [](int x, int, int c) { return 0.1f + 0.2f * static_cast<float>((x + c) % 3); });
    FillImage<3>(&f.signals.back().radiance, [](int x, int, int c) {
      return 3.0f * (0.1f + 0.2f * static_cast<float>((x + c) % 3));
    });
    FillImage<3>(&Light(&f, SignalKind::kDirectDiffuse), [](int, int, int) { return 0.25f; });
    return f;
  };
  for (const char* signals : {"split", "diffuse_specular"}) {
    Settings s;
    ASSERT_TRUE(SetParameter(&s, "signals", signals).ok());
    Denoiser d = MakeDenoiser(s);
    ASSERT_TRUE(d.SetOutputs({"filtered.transmission"}).ok());
    DenoisedFrame out;
    for (int i = 0; i < 3; ++i) {
      ASSERT_TRUE(d.Denoise(make(i), &out).ok());
    }
    ASSERT_EQ(out.images.size(), 1u);
    EXPECT_NEAR(out.images[0].channels[0](10, 10), 3.0f, 1e-5f);  // demodulated: no texture left
    for (int x = 0; x < 32; ++x) {
      EXPECT_NEAR(out.colour[0](x, 10), 0.25f + 3.0f * (0.1f + 0.2f * static_cast<float>(x % 3)),
                  1e-4f);
    }
    // A history with transmission goes on with it.
    Denoiser resumed = MakeDenoiser(s);
    ASSERT_TRUE(resumed.RestoreHistory(d.SaveHistory().value()).ok());
    DenoisedFrame next;
    ASSERT_TRUE(resumed.Denoise(make(3), &next).ok());
    ASSERT_TRUE(d.Denoise(make(3), &out).ok());
    EXPECT_TRUE(SameBits(next.colour, out.colour));
  }
  Frame missing = make(0);
  missing.guides.transmission_albedo = Image3();
  Denoiser d = MakeDenoiser(Settings());
  DenoisedFrame out;
  EXPECT_THAT(d.Denoise(missing, &out).message(), HasSubstr("'transmission_albedo[0]' is missing"));
}

TEST(Denoiser, ReachOfFiveLevels) {
  // A single bright pixel in a still black picture without edge stops: 5 levels of 5x5 reach 62
  // pixels to each side, of 3x3 reach 31.
  for (const auto& [kernel, reach] : {std::pair{"5x5", 62}, std::pair{"3x3", 31}}) {
    Settings s = PresetSettings("eaw").value();
    ASSERT_TRUE(SetParameter(&s, "wavelet", "naive").ok());
    ASSERT_TRUE(SetParameter(&s, "kernel", kernel).ok());
    Denoiser d = MakeDenoiser(s);
    Frame f = MakeWall(160, 160);
    Light(&f, SignalKind::kDirectDiffuse)[0](80, 80) = 1e6f;
    DenoisedFrame out;
    ASSERT_TRUE(d.Denoise(f, &out).ok());
    EXPECT_GT(out.colour[0](80 + reach, 80), 0.0f);
    EXPECT_GT(out.colour[0](80, 80 - reach), 0.0f);
    EXPECT_GT(out.colour[0](80 + reach, 80 + reach), 0.0f);
    EXPECT_EQ(out.colour[0](80 + reach + 1, 80), 0.0f);
    EXPECT_EQ(out.colour[0](80, 80 + reach + 1), 0.0f);
  }
}

TEST(Denoiser, EveryParameterChangesThePicture) {
  // What each parameter is moved to, and what else it needs to matter.
  struct Move {
    const char* name;
    const char* value;
    std::vector<std::pair<const char*, const char*>> with;
  };
  const std::vector<Move> moves = {
      {"fill_guides", "off", {}},
      {"signals", "single", {}},
      {"demodulate", "off", {}},
      {"firefly", "clamp", {}},
      {"temporal", "off", {}},
      {"history_weight", "constant", {}},
      {"alpha_min", "0.5", {}},
      {"alpha_moments", "0.9", {}},
      {"max_history", "2", {}},
      {"history_depth",
       "10",
       {{"history_id", "off"}, {"history_normal", "180"}, {"history_search", "off"}}},
      {"history_normal", "0.5", {}},
      {"history_id", "off", {{"history_depth", "10"}, {"history_normal", "180"}}},
      {"history_search", "off", {}},
      {"limit_history", "off", {{"limit_dead", "0"}}},
      {"limit_gain", "200", {{"limit_dead", "0"}}},
      {"limit_dead", "0", {{"limit_gain", "200"}}},
      {"variance_of", "frame", {}},
      {"short_history", "blur", {}},
      {"short_history_length", "0", {}},
      {"short_history_boost", "4", {}},
      {"prefilter_variance", "off", {}},
      {"wavelet", "eaw", {}},
      {"kernel", "3x3", {}},
      {"steps", "16,8,4,2,1", {}},
      {"feedback", "1", {}},
      {"feedback_when", "frame", {{"feedback", "2"}}},
      {"sigma_n", "8", {}},
      {"depth_weight", "gradient", {}},
      {"sigma_z", "20", {{"depth_weight", "gradient"}}},
      {"plane_tolerance", "1", {}},
      {"depth_epsilon", "0.5", {{"depth_weight", "gradient"}}},
      {"max_slope", "0.0001", {{"depth_weight", "gradient"}}},
      {"sigma_l", "1", {}},
      {"luminance_epsilon", "1", {}},
      {"noise_ratio", "1", {}},
      {"luminance", "rec601", {}},
      {"luminance_scale", "variance", {}},
      {"wavelet_id", "on", {{"plane_tolerance", "10"}, {"sigma_n", "1"}}},
      {"eaw_sigma_l", "0.1", {{"wavelet", "eaw"}}},
      {"eaw_sigma_n", "0.05", {{"wavelet", "eaw"}}},
      {"eaw_sigma_z", "5", {{"wavelet", "eaw"}, {"eaw_sigma_n", "5"}}},
      {"antialias", "off", {}},
      {"taa_alpha", "0.5", {}},
      {"fxaa", "on", {}},
      {"exposure", "1", {}},
      {"tonemap", "linear", {}},
      {"dither", "2", {}},
  };
  const auto picture = [](const Settings& s) {
    Denoiser d = MakeDenoiser(s);
    DenoisedFrame out;
    for (int i = 0; i < 8; ++i) {
      Frame f = MakeBusyFrame(48, 40, i);
      // Nothing is known of a block without samples, for fill_guides.
      for (int y = 20; y < 24; ++y) {
        for (int x = 20; x < 28; ++x) {
          f.samples(x, y) = 0;
          f.guides.depth(x, y) = 0;
        }
      }
      EXPECT_TRUE(d.Denoise(f, &out).ok());
    }
    return ToDisplay(out.colour, s.exposure, s.tonemap, s.dither, 1);
  };
  for (const Parameter& p : Parameters()) {
    const auto move = std::find_if(moves.begin(), moves.end(),
                                   [&](const Move& m) { return std::string(m.name) == p.name; });
    ASSERT_NE(move, moves.end()) << "no test moves '" << p.name << "'";
    Settings before;
    for (const auto& [name, value] : move->with) {
      ASSERT_TRUE(SetParameter(&before, name, value).ok());
    }
    Settings after = before;
    ASSERT_TRUE(SetParameter(&after, p.name, move->value).ok());
    EXPECT_NE(picture(before), picture(after)) << p.name;
  }
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

TEST(Denoiser, AChangeOfSizeStartsAnew) {
  Denoiser d = MakeDenoiser(Settings());
  Denoiser fresh = MakeDenoiser(Settings());
  DenoisedFrame a;
  DenoisedFrame b;
  ASSERT_TRUE(d.Denoise(MakeBusyFrame(30, 20, 0), &a).ok());
  ASSERT_TRUE(d.Denoise(MakeBusyFrame(21, 40, 1), &a).ok());
  ASSERT_TRUE(fresh.Denoise(MakeBusyFrame(21, 40, 1), &b).ok());
  EXPECT_TRUE(SameBits(a.colour, b.colour));
}

TEST(Denoiser, DemodulationKeepsTextureSharp) {
  // Constant light on a checkerboard of 1-pixel squares comes out as it went in.
  for (const char* preset : {"default", "svgf", "eaw"}) {
    Denoiser d = MakeDenoiser(PresetSettings(preset).value());
    DenoisedFrame out;
    const auto albedo = [](int x, int y) { return (x + y) % 2 == 0 ? 0.9f : 0.1f; };
    for (int i = 0; i < 5; ++i) {
      Frame f = MakeWall(32, 32, i);
      FillImage<3>(&f.guides.albedo, [&](int x, int y, int) { return albedo(x, y); });
      FillImage<3>(&f.guides.specular_albedo, [](int, int, int) { return 0.0f; });
      FillImage<3>(&Light(&f, SignalKind::kDirectDiffuse),
                   [&](int x, int y, int) { return 2.0f * albedo(x, y); });
      ASSERT_TRUE(d.Denoise(f, &out).ok());
    }
    EXPECT_NEAR(out.colour[0](15, 15), 1.8f, 1e-4f) << preset;
    EXPECT_NEAR(out.colour[0](16, 15), 0.2f, 1e-4f) << preset;
  }
}

TEST(Denoiser, BlackHistoryEndsWhenLightComes) {
  for (const Backend backend : {Backend::kReference, Backend::kCpu}) {
    Denoiser d = MakeDenoiser(PresetSettings("default").value(), backend);
    ASSERT_TRUE(d.SetOutputs({"limit.direct"}).ok());
    Frame frame = MakeWall(40, 30);
    DenoisedFrame out;
    for (int i = 0; i < 8; ++i) {
      ASSERT_TRUE(d.Denoise(frame, &out).ok());
    }
    Light(&frame, SignalKind::kDirectDiffuse)[1].Fill(1);
    ASSERT_TRUE(d.Denoise(frame, &out).ok());
    EXPECT_LT(out.images[0].channels[0](20, 15), 0.1f);
    EXPECT_GT(out.colour[1](20, 15), 0.9f);
  }
}

TEST(Denoiser, AChangeOfLightEndsHistory) {
  // The light doubles at once. With limit_history the picture follows within a few frames, without
  // it lags.
  const auto after = [](bool limit) {
    Settings s;
    s.limit_history = limit;
    s.antialias = Antialias::kOff;
    Denoiser d = MakeDenoiser(s);
    DenoisedFrame out;
    for (int i = 0; i < 33; ++i) {
      Frame f = MakeWall(64, 48, i);
      const float level = i < 30 ? 1.0f : 3.0f;
      FillImage<3>(&Light(&f, SignalKind::kDirectDiffuse), [&](int x, int y, int) {
        return level * (0.5f + test::Random(static_cast<uint32_t>(i), static_cast<uint32_t>(x),
                                            static_cast<uint32_t>(y)));
      });
      EXPECT_TRUE(d.Denoise(f, &out).ok());
    }
    double sum = 0;
    for (int x = 0; x < 64; ++x) {
      sum += out.colour[0](x, 24) / 64;
    }
    return sum;
  };
  EXPECT_NEAR(after(true), 3.0, 0.15);
  EXPECT_LT(after(false), 1.7);
}

}  // namespace
}  // namespace stillray
