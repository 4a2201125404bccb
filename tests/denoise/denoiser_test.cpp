// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The whole pipeline: properties under all settings, and parity of the SIMD version with the scalar
// reference on every instruction set.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <hwy/targets.h>
#include <oneapi/tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>

#include "denoise/make_denoiser.h"
#include "denoise/test_frames.h"
#include "stillray/denoise.hpp"

namespace stillray::denoiser_test {
namespace {

using test::FillImage;
using test::Light;
using test::MakeBusyFrame;
using test::MakeDenoiser;
using test::MakeWall;
using test::SameBits;
using ::testing::HasSubstr;

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
  // limit_history shortens histories to any length, so that rounding could decide which are short.
  add("default", {{"limit_history", "off"},
                  {"short_history", "blur"},
                  {"luminance", "rec601"},
                  {"luminance_scale", "variance"}});
  add("default", {{"signals", "single"}, {"demodulate", "off"}, {"firefly", "clamp"}});
  add("default", {{"signals", "channels"}});
  add("svgf", {{"firefly", "compress"},
               {"wavelet_id", "on"},
               {"steps", "4,2,1"},
               {"prefilter_variance", "off"}});
  add("default",
      {{"signals", "diffuse_specular"}, {"history_search", "off"}, {"max_history", "5"}});
  return all;
}

TEST(Denoiser, VectorVersionMatchesReferenceOnEveryTarget) {
  // Both differ in rounding and in the approximated exponentials (up to 1.5e-5). That grows where a
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
    for (const int64_t target : hwy::SupportedAndGeneratedTargets()) {
      hwy::SetSupportedTargetsForTest(target);
      Denoiser cpu = MakeDenoiser(s);
      for (int i = 0; i < 7; ++i) {
        DenoisedFrame out;
        ASSERT_TRUE(cpu.Denoise(MakeBusyFrame(width, height, i), &out).ok());
        const Image3& reference_colour = expected[static_cast<size_t>(i)];
        EXPECT_LT(RmsError(out.colour, reference_colour), kRmsTolerance) << "frame " << i;
        EXPECT_LT(LargestError(out.colour, reference_colour), kTolerance)
            << "frame " << i << " target " << hwy::TargetName(target) << " wavelet "
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
    // SharedLuminanceFactor): a known darkening, which "default" nearly avoids.
    EXPECT_NEAR(mean, 0.5, std::string_view(preset) == "svgf" ? 0.02 : 0.006) << preset;
  }
}

/// Brightness of the first frame of a wall over that of its samples, which have this mean at each
/// column, and light with this probability.
double FirstFrameBrightness(const Settings& settings, SignalKind kind, float probability,
                            const std::function<float(int)>& mean) {
  Frame frame = MakeWall(192, 128);
  FillImage<3>(&Light(&frame, kind), [&](int x, int y, int) {
    const bool lit =
        test::Random(static_cast<uint32_t>(x), static_cast<uint32_t>(y), 5) < probability;
    return lit ? mean(x) / probability : 0.0f;
  });
  Denoiser denoiser = MakeDenoiser(settings);
  DenoisedFrame out;
  EXPECT_TRUE(denoiser.Denoise(frame, &out).ok());
  double given = 0;
  double got = 0;
  for (int y = 0; y < frame.height; ++y) {
    for (int x = 0; x < frame.width; ++x) {
      given += static_cast<double>(Light(&frame, kind)[0](x, y));
      got += static_cast<double>(out.colour[0](x, y));
    }
  }
  return got / given;
}

// Pixels of few samples take their own noise for signal, and refuse brighter neighbours more often
// than darker ones.
TEST(Denoiser, FirstFramesKeepTheMeanOfSkewedLight) {
  const Settings settings;
  const auto flat = [](int) { return 1.0f; };
  const auto penumbra = [](int x) {
    return std::clamp(static_cast<float>(x - 64) / 64, 0.0f, 1.0f);
  };
  const auto brightness = [&](SignalKind kind, float probability, const auto& mean) {
    return FirstFrameBrightness(settings, kind, probability, mean);
  };
  for (const SignalKind kind : {SignalKind::kDirectDiffuse, SignalKind::kIndirectDiffuse}) {
    EXPECT_NEAR(brightness(kind, 0.5f, flat), 1, 0.003) << "samples of 0 and 2";
    EXPECT_NEAR(brightness(kind, 0.5f, penumbra), 1, 0.01) << "across a penumbra";
    EXPECT_NEAR(brightness(kind, 0.2f, flat), 1, 0.01) << "of 0 and 5";
  }
  EXPECT_NEAR(brightness(SignalKind::kIndirectDiffuse, 0.1f, flat), 1, 0.015) << "of 0 and 10";
  const Settings svgf = PresetSettings("svgf").value();
  EXPECT_LT(FirstFrameBrightness(svgf, SignalKind::kIndirectDiffuse, 0.1f, flat), 0.97);
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

TEST(Denoiser, TransmissionIsASignalOfItsOwn) {
  // The sum of reflected and transmitted light, each with its own albedo.
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
  Frame wrong = make(0);
  wrong.guides.transmission_albedo = Image3(31, 32);
  Denoiser d = MakeDenoiser(Settings());
  DenoisedFrame out;
  EXPECT_THAT(d.Denoise(wrong, &out).message(), HasSubstr("'transmission_albedo[0]' is 31x32"));
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
  // A new value for each parameter, and other values under which it has an effect.
  struct Move {
    const char* name;
    const char* value;
    std::vector<std::pair<const char*, const char*>> with;
  };
  const std::vector<Move> moves = {
      {"fill_guides", "off", {}},
      {"normals", "octahedral", {{"sigma_n", "1024"}, {"curvature", "0"}}},
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
      {"history_taps", "nearest", {}},
      {"history_search", "off", {}},
      {"limit_history", "off", {{"limit_dead", "0"}}},
      {"correct_history", "off", {}},
      {"limit_gain", "200", {{"limit_dead", "0"}}},
      {"limit_dead", "0", {{"limit_gain", "200"}}},
      {"variance_of", "frame", {}},
      {"short_history", "blur", {}},
      {"short_history_window",
       "5x5",
       {{"short_history", "spatial"}, {"short_history_window", "7x7"}}},
      {"short_history_length", "0", {}},
      {"short_history_boost", "4", {}},
      {"prefilter_variance", "off", {}},
      {"prefilter_limit", "1", {}},
      {"wavelet", "eaw", {}},
      {"kernel", "3x3", {}},
      {"steps", "16,8,4,2,1", {}},
      {"feedback", "1", {}},
      {"feedback_when", "frame", {{"feedback", "2"}}},
      {"sigma_n", "8", {}},
      {"curvature", "4", {}},
      {"depth_weight", "gradient", {}},
      {"sigma_z", "20", {{"depth_weight", "gradient"}}},
      {"plane_tolerance", "1", {}},
      {"position_sigma", "0.01", {{"depth_weight", "position"}}},
      {"depth_epsilon", "0.5", {{"depth_weight", "gradient"}}},
      {"max_slope", "0.0001", {{"depth_weight", "gradient"}}},
      {"sigma_l", "1", {}},
      {"luminance_epsilon", "1", {}},
      {"luminance_floor", "1", {}},
      {"pilot", "off", {}},
      {"noise_ratio", "1", {}},
      {"luminance", "rec601", {}},
      {"luminance_scale", "variance", {}},
      {"wavelet_id", "on", {{"plane_tolerance", "10"}, {"sigma_n", "1"}}},
      {"eaw_sigma_l", "0.1", {{"wavelet", "eaw"}}},
      {"eaw_sigma_n", "0.05", {{"wavelet", "eaw"}}},
      {"eaw_sigma_z", "5", {{"wavelet", "eaw"}, {"eaw_sigma_n", "5"}}},
      {"clip_outliers", "0", {}},
      {"restore_energy", "off", {}},
      {"virtual_roughness", "0", {}},
      {"virtual_motion_roughness", "0", {}},
      {"mirror_roughness", "0", {}},
      {"keep_samples", "off", {}},
      {"restore_detail", "on", {}},
      {"antialias", "off", {}},
      {"taa_alpha", "0.5", {}},
      {"taa_moving_alpha", "1", {}},
      {"taa_filter", "catmull_rom", {}},
      {"taa_extrapolate_motion", "off", {}},
      {"taa_clamp", "picture", {}},
      {"taa_follow_light", "off", {}},
      {"taa_tonemapped", "on", {}},
      {"fxaa", "on", {}},
      {"exposure", "1", {}},
      {"tonemap", "linear", {}},
      {"dither", "2", {}},
  };
  const auto picture = [](const Settings& s, bool several_samples, int scale) {
    const int width = 48 * scale;
    const int height = 40 * scale;
    Denoiser d = MakeDenoiser(s);
    DenoisedFrame out;
    for (int i = 0; i < 8; ++i) {
      Frame f = MakeBusyFrame(width, height, i);
      if (several_samples) {
        f.samples.Fill(16);
        f.signals.front().second_moment = Image1(width, height);
      }
      // Nothing is known of a block without samples, for fill_guides.
      for (int y = 20; y < 24; ++y) {
        for (int x = 20; x < 28; ++x) {
          f.samples(x, y) = 0;
          f.guides.depth(x, y) = 0;
        }
      }
      // The lower mirrors show something else, for select_guides.
      f.reflection.depth = Image1(width, height);
      FillImage(&f.reflection.depth,
                [](int x, int y) { return y < 30 ? 0.0f : 20.0f + static_cast<float>(x % 4); });
      f.reflection.motion = f.guides.motion;
      for (int x = 0; x < width; ++x) {
        for (int y = 30; y < height; ++y) {
          f.reflection.motion[0](x, y) += 2;
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
    const bool several_samples = std::string(p.name) == "keep_samples";
    // Blocks of pixels without another surface beside them, for follow_light.
    const int scale = std::string(p.name) == "taa_follow_light" ? 3 : 1;
    EXPECT_NE(picture(before, several_samples, scale), picture(after, several_samples, scale))
        << p.name;
  }
}

TEST(Denoiser, PrefilterVarianceHasThreeWays) {
  // off, once and on differ from each other, and a flag's spellings still mean off and on.
  Settings settings;
  std::vector<Image3> pictures;
  for (const char* way : {"off", "once", "on"}) {
    ASSERT_TRUE(SetParameter(&settings, "prefilter_variance", way).ok());
    Denoiser d = MakeDenoiser(settings);
    DenoisedFrame out;
    for (int i = 0; i < 2; ++i) {
      ASSERT_TRUE(d.Denoise(MakeBusyFrame(48, 40, i), &out).ok());
    }
    for (const Image3& other : pictures) {
      EXPECT_FALSE(SameBits(out.colour, other)) << way;
    }
    pictures.push_back(out.colour);
  }
  for (const auto& [spelling, value] : {std::pair{"true", "on"}, {"0", "off"}, {"1", "on"}}) {
    ASSERT_TRUE(SetParameter(&settings, "prefilter_variance", spelling).ok());
    EXPECT_EQ(GetParameter(settings, "prefilter_variance").value(), value);
  }
  EXPECT_FALSE(SetParameter(&settings, "prefilter_variance", "twice").ok());
}

TEST(Denoiser, OneLevelPrefilteredOnceIsPrefilteredBeforeIt) {
  // The first level compares the same smoothed variance either way.
  Settings settings = PresetSettings("svgf").value();
  ASSERT_TRUE(SetParameter(&settings, "steps", "2").ok());
  Image1 pictures[2];
  for (const int once : {0, 1}) {
    settings.prefilter_variance = once == 1 ? PrefilterVariance::kOnce : PrefilterVariance::kOn;
    Denoiser d = MakeDenoiser(settings);
    DenoisedFrame out;
    ASSERT_TRUE(d.Denoise(MakeBusyFrame(48, 40, 0), &out).ok());
    pictures[once] = out.colour[0];
  }
  for (int y = 0; y < 40; ++y) {
    for (int x = 0; x < 48; ++x) {
      EXPECT_NEAR(pictures[0](x, y), pictures[1](x, y), 1e-5f * (1 + pictures[0](x, y)));
    }
  }
}

TEST(Denoiser, LuminanceFloorSmoothsDimLight) {
  // Columns of 0.01 and 0.02, and of 1 and 2, with a variance of zero: without a floor every column
  // keeps its light, with one of 0.1 the dim ones become their mean.
  for (const float floor : {0.0f, 0.1f}) {
    Settings settings = PresetSettings("svgf").value();
    settings.short_history_length = 0;
    settings.luminance_epsilon = 0;
    settings.luminance_floor = floor;
    Denoiser d = MakeDenoiser(settings);
    Frame f = MakeWall(64, 32, 0);
    FillImage<3>(&f.guides.albedo, [](int, int, int) { return 1.0f; });
    FillImage<3>(&f.guides.specular_albedo, [](int, int, int) { return 0.0f; });
    FillImage<3>(&Light(&f, SignalKind::kDirectDiffuse), [](int x, int y, int) {
      return static_cast<float>(1 + x % 2) * (y < 16 ? 0.01f : 1.0f);
    });
    DenoisedFrame out;
    ASSERT_TRUE(d.Denoise(f, &out).ok());
    EXPECT_NEAR(out.colour[0](30, 4), floor > 0 ? 0.015f : 0.01f, 5e-4f) << floor;
    EXPECT_NEAR(out.colour[0](31, 4), floor > 0 ? 0.015f : 0.02f, 5e-4f) << floor;
    EXPECT_NEAR(out.colour[0](30, 28), 1.0f, 1e-3f) << floor;
    EXPECT_NEAR(out.colour[0](31, 28), 2.0f, 1e-3f) << floor;
  }
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

}  // namespace
}  // namespace stillray::denoiser_test
