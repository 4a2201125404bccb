// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Frames that say how far the light of the last frame still holds (Frame::confidence).
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "denoise/every_target.h"
#include "denoise/make_denoiser.h"
#include "denoise/next_motion.h"
#include "denoise/output_names.h"
#include "denoise/stage_parity.h"
#include "denoise/stage_planes.h"
#include "denoise/stage_table.h"
#include "denoise/stages/accumulate.h"
#include "denoise/stages/reproject.h"
#include "denoise/test_frames.h"
#include "stillray/two_way.hpp"

namespace stillray::confidence_test {
namespace {

using test::Denoised;
using test::Light;
using test::MakeBusyFrame;
using test::MakeDenoiser;
using test::MakeSparseLight;
using test::MakeWall;
using test::OnEveryTarget;
using test::SameBits;
using testing::HasSubstr;

constexpr int kWidth = 48;
constexpr int kHeight = 32;
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr const char* kPresets[] = {"default", "svgf", "psvgf", "eaw", "temporal", "best"};

Image1 Filled(float value, int width = kWidth, int height = kHeight) {
  Image1 plane(width, height);
  plane.Fill(value);
  return plane;
}

/// Every kind of value: between 0 and 1, both ends, outside and not a number.
Image1 AnyConfidence(int width, int height, int64_t frame) {
  Image1 plane(width, height);
  constexpr float kValues[] = {0, 1, 0.5f, -2, 3, kNan, kInfinity, -kInfinity};
  test::FillImage(&plane, [&](int x, int y) {
    const float u =
        test::Random(static_cast<uint32_t>(y * width + x), 3u, static_cast<uint32_t>(frame));
    return u < 0.5f ? kValues[static_cast<size_t>(16 * u)] : 2 * u - 1;
  });
  return plane;
}

/// What a denoiser should make of a given value.
float Used(float given) {
  return std::isnan(given) ? 1.0f : std::fmin(std::fmax(given, 0.0f), 1.0f);
}

/// Outputs of the last frame. \param kinds  "history" is that of all signals
std::vector<NamedImage> Outputs(const Settings& settings, const std::vector<Frame>& frames,
                                const std::vector<std::string>& kinds, Backend backend) {
  Denoiser denoiser = MakeDenoiser(settings, backend);
  DenoisedFrame out;
  std::vector<std::string> names;
  for (const std::string& kind : kinds) {
    AddOutputs(Denoiser::OutputNames(settings), kind, &names);
  }
  EXPECT_TRUE(denoiser.SetOutputs(names).ok());
  for (const Frame& frame : frames) {
    EXPECT_TRUE(denoiser.Denoise(frame, &out).ok());
  }
  return std::move(out.images);
}

std::vector<Frame> BusyFrames(int count) {
  std::vector<Frame> frames;
  for (int i = 0; i < count; ++i) {
    frames.push_back(MakeBusyFrame(kWidth, kHeight, i));
  }
  return frames;
}

/// A wall under one sample per pixel whose lamp has this brightness.
Frame MakeLamp(int64_t index, float brightness) {
  return MakeSparseLight(kWidth, kHeight, index, 0, 3 * brightness);
}

TEST(ConfidenceFormulas, ValuesAreClampedAndNanIsOne) {
  for (const float given : {-3.0f, 0.0f, 0.25f, 1.0f, 7.0f, kInfinity, -kInfinity}) {
    EXPECT_EQ(UsedConfidence(given, false), Used(given)) << given;
  }
  EXPECT_EQ(UsedConfidence(kNan, true), 1.0f);
}

TEST(ConfidenceFormulas, LengthIsThatOfTheEffectiveSamples) {
  EXPECT_EQ(ConfidentLength(8, 1.0f / 8, 0.5f), 4);
  EXPECT_EQ(ConfidentLength(8, 1.0f / 8, 0), 0);
  // Under alpha_min the length grows on, and the number of effective samples does not.
  EXPECT_FLOAT_EQ(ConfidentLength(1000, 1.0f / 19, 0.25f), 19 * 0.25f);
  EXPECT_EQ(ConfidentLength(1000, 1.0f / 19, 1), 1000);
  EXPECT_EQ(ConfidentLength(0, 0, 0.5f), 0);
}

TEST(ConfidenceFormulas, WeightOfTheHistoryIsInProportion) {
  for (const float alpha : {0.01f, 0.1f, 0.2f, 0.7f, 1.0f}) {
    EXPECT_EQ(ConfidentAlpha(alpha, 1), alpha);
    EXPECT_EQ(ConfidentAlpha(alpha, 0), 1);
    for (const float confidence : {0.001f, 0.3f, 0.5f, 0.99f}) {
      const auto a = static_cast<double>(ConfidentAlpha(alpha, confidence));
      const double before = (1 - static_cast<double>(alpha)) / static_cast<double>(alpha);
      EXPECT_NEAR((1 - a) / a, static_cast<double>(confidence) * before, 1e-5 * (1 + before));
      // That of a history of the length that alpha stands for, shortened.
      const auto share =
          static_cast<double>(NewFrameWeight(confidence * static_cast<float>(before), 1, 0, false));
      EXPECT_NEAR(a, share, 1e-5);
    }
  }
  EXPECT_EQ(ConfidentAlpha(0, 0.5f), 0);
  EXPECT_TRUE(std::isfinite(ConfidentAlpha(0, 0)));
}

// Stages.

struct Fetching {
  GuidePlanes before = test::MakeGuides(false);
  GuidePlanes now = test::MakeGuides(true);
  SignalHistory history = test::MakeHistory(false);
  Image1 confidence = AnyConfidence(test::kWidth, test::kHeight, 5);
  Image2 motion = Image2(test::kWidth, test::kHeight);

  explicit Fetching(float shift) { motion[0].Fill(shift); }
  ReprojectionTaps Taps(const StageTable& stages) const {
    ReprojectionTaps taps(test::kWidth, test::kHeight);
    stages.find_taps(now, before, motion, test::DefaultPlan().reproject, &taps);
    return taps;
  }
};

TEST(ConfidenceInFetch, ShortensTheHistoryAndDropsItsLight) {
  for (const float shift : {0.0f, 0.4f, -1.75f}) {
    const Fetching f(shift);
    const ReprojectionTaps of_geometry = f.Taps(kReferenceStages);
    OnEveryTarget([&] {
      for (const StageTable* stages : {&kReferenceStages, &kCpuStages}) {
        ReprojectionTaps taps = f.Taps(*stages);
        SignalHistory whole = f.history;
        stages->fetch_history(f.history, taps, &whole);
        taps.confidence = &f.confidence;
        SignalHistory fetched = f.history;
        stages->fetch_history(f.history, taps, &fetched);
        for (int y = 0; y < test::kHeight; ++y) {
          for (int x = 0; x < test::kWidth; ++x) {
            const float c = Used(f.confidence(x, y));
            const float effective = std::fmin(whole.length(x, y), 1 / whole.weights2(x, y));
            const float length = c < 1 ? c * effective : whole.length(x, y);
            ASSERT_NEAR(fetched.length(x, y), length, 1e-4) << x << ", " << y;
            const float light = c > 0 ? whole.colour[1](x, y) : 0.0f;
            ASSERT_EQ(fetched.colour[1](x, y), light) << x << ", " << y;
            ASSERT_EQ(fetched.behind[2](x, y), c > 0 ? whole.behind[2](x, y) : 0.0f);
            ASSERT_EQ(fetched.mean(x, y), c > 0 ? whole.mean(x, y) : 0.0f);
            ASSERT_EQ(fetched.variance(x, y), c > 0 ? whole.variance(x, y) : 0.0f);
            ASSERT_EQ(fetched.weights2(x, y), c > 0 ? whole.weights2(x, y) : 0.0f);
            ASSERT_EQ(fetched.compressed(x, y), c > 0 ? whole.compressed(x, y) : 0.0f);
            // Disocclusions are those of the geometry.
            ASSERT_EQ(taps.HasHistory(x, y), of_geometry.HasHistory(x, y));
          }
        }
      }
    });
  }
}

TEST(ConfidenceInAccumulate, AllVersionsAgree) {
  AccumulateParameters constant = test::DefaultPlan().accumulate;
  constant.history_weight_constant = 1;
  AccumulateParameters capped = test::DefaultPlan().accumulate;
  capped.max_history = 3;
  const NewLight light = test::MakeLight(0.8f);
  const Image1 bias = AnyConfidence(test::kWidth, test::kHeight, 6);
  Image1 small_bias(test::kWidth, test::kHeight);
  test::FillImage(&small_bias, [&](int x, int y) { return 0.1f * Used(bias(x, y)); });
  const Image1 ratio = Filled(1.25f, test::kWidth, test::kHeight);
  for (const float shift : {0.0f, 0.4f}) {
    const Fetching f(shift);
    for (const AccumulateParameters& p : {test::DefaultPlan().accumulate, constant, capped}) {
      for (const HistoryLimits& limits : {HistoryLimits(), HistoryLimits{&small_bias, &ratio, 8}}) {
        ReprojectionTaps taps = f.Taps(kReferenceStages);
        taps.confidence = &f.confidence;
        SignalHistory expected = f.history;
        reference::Accumulate(light, f.history, &taps, limits, p, &expected);
        OnEveryTarget([&] {
          ReprojectionTaps own = f.Taps(kCpuStages);
          own.confidence = &f.confidence;
          SignalHistory got = f.history;
          cpu::Accumulate(light, f.history, &own, limits, p, &got);
          for (int y = 0; y < test::kHeight; ++y) {
            for (int x = 0; x < test::kWidth; ++x) {
              for (int c = 0; c < 3; ++c) {
                ASSERT_NEAR(got.colour[c](x, y), expected.colour[c](x, y), 1e-5);
              }
              ASSERT_NEAR(got.length(x, y), expected.length(x, y), 1e-4) << x << ", " << y;
              ASSERT_NEAR(got.weights2(x, y), expected.weights2(x, y), 1e-5) << x << ", " << y;
              ASSERT_NEAR(got.variance(x, y), expected.variance(x, y), 1e-4) << x << ", " << y;
              ASSERT_NEAR(got.compressed(x, y), expected.compressed(x, y), 1e-5);
            }
          }
        });
      }
    }
  }
}

TEST(ConfidenceInAccumulate, TheSmallerOfBothLengthsWins) {
  // One pixel: eight samples of light 1, and this frame's of light 0.
  NewLight light = {LumaImage3(1, 1), Filled(1, 1, 1), Image1()};
  SignalHistory before(1, 1);
  before.length.Fill(8);
  before.weights2.Fill(1.0f / 8);
  before.colour[0].Fill(1);
  ReprojectionTaps taps(1, 1);
  taps.weight[0].Fill(1);
  AccumulateParameters p = test::DefaultPlan().accumulate;
  p.alpha_min = p.alpha_moments = 0.01f;
  const Image1 ratio = Filled(1, 1, 1);
  const auto length_of = [&](float confidence, float limit) {
    const Image1 plane = Filled(confidence, 1, 1);
    taps.confidence = &plane;
    // The bias that LimitedLength turns into this length.
    const Image1 bias = Filled(1 / limit - 1.0f / 8, 1, 1);
    SignalHistory out(1, 1);
    reference::Accumulate(light, before, &taps, {&bias, &ratio, 1}, p, &out);
    const float kept = out.length(0, 0) - 1;
    EXPECT_NEAR(out.colour[0](0, 0), kept / (kept + 1), 1e-5);
    return kept;
  };
  EXPECT_NEAR(length_of(0.5f, 2), 2, 1e-4);
  EXPECT_NEAR(length_of(0.5f, 6), 4, 1e-4);
  EXPECT_NEAR(length_of(1, 6), 6, 1e-4);
}

// Whole frames.

TEST(Confidence, OneEverywhereHasTheBitsOfNone) {
  const std::vector<Frame> without = BusyFrames(5);
  std::vector<Frame> with = without;
  for (Frame& f : with) {
    f.confidence = Filled(1);
  }
  std::vector<Frame> above = without;
  for (Frame& f : above) {
    f.confidence = Filled(4);
  }
  for (const char* preset : kPresets) {
    const Settings settings = PresetSettings(preset).value();
    const Image3 expected = Denoised(settings, without);
    EXPECT_TRUE(SameBits(Denoised(settings, with), expected)) << preset;
    EXPECT_TRUE(SameBits(Denoised(settings, above), expected)) << preset;
  }
}

TEST(Confidence, ConstantLightStaysConstant) {
  std::vector<Frame> frames;
  for (int i = 0; i < 6; ++i) {
    frames.push_back(MakeWall(kWidth, kHeight, i));
    for (int c = 0; c < 3; ++c) {
      Light(&frames.back(), SignalKind::kDirectDiffuse)[c].Fill(0.8f);
    }
    frames.back().guides.motion[0].Fill(i % 2 == 0 ? 0.0f : 0.6f);
    frames.back().confidence = AnyConfidence(kWidth, kHeight, i);
  }
  for (const char* preset : kPresets) {
    const Image3 out = Denoised(PresetSettings(preset).value(), frames);
    for (int c = 0; c < 3; ++c) {
      for (int y = 0; y < kHeight; ++y) {
        for (int x = 0; x < kWidth; ++x) {
          ASSERT_NEAR(out[c](x, y), 0.8f, 1e-4) << preset << " " << x << ", " << y;
        }
      }
    }
  }
}

TEST(Confidence, ZeroIsAFirstFrameOfTheLight) {
  std::vector<Frame> frames = BusyFrames(6);
  const Frame last = frames.back();
  frames.back().confidence = Filled(0);
  test::FillImage(&frames.back().confidence, [](int x, int) { return x < 20 ? 0.0f : 1.0f; });
  for (const Backend backend : {Backend::kCpu, Backend::kReference}) {
    for (const char* preset : kPresets) {
      const Settings settings = PresetSettings(preset).value();
      const std::vector<std::string> names = {"accumulated", "history", "moment_mean",
                                              "moment_variance"};
      const auto got = Outputs(settings, frames, names, backend);
      const auto first = Outputs(settings, {last}, names, backend);
      ASSERT_EQ(got.size(), first.size());
      int held = 0;
      for (size_t i = 0; i < got.size(); ++i) {
        for (size_t c = 0; c < got[i].channels.size(); ++c) {
          for (int y = 0; y < kHeight; ++y) {
            for (int x = 0; x < kWidth; ++x) {
              const float value = got[i].channels[c](x, y);
              if (x < 20) {
                ASSERT_EQ(value, first[i].channels[c](x, y))
                    << preset << " " << got[i].name << " " << x << ", " << y;
              } else {
                held += value != first[i].channels[c](x, y) ? 1 : 0;
              }
            }
          }
        }
      }
      EXPECT_TRUE(held > 200 || !settings.temporal) << preset;
    }
  }
}

TEST(Confidence, HalfOfItHalvesTheLength) {
  for (const char* preset : kPresets) {
    const Settings settings = PresetSettings(preset).value();
    if (!settings.temporal) {
      continue;
    }
    std::vector<Frame> frames;
    for (int i = 0; i < 5; ++i) {
      frames.push_back(MakeWall(kWidth, kHeight, i));
      for (int c = 0; c < 3; ++c) {
        Light(&frames.back(), SignalKind::kDirectDiffuse)[c].Fill(0.8f);
      }
    }
    frames.back().confidence = Filled(0.5f);
    const auto out = Outputs(settings, frames, {"history"}, Backend::kCpu);
    // Of four samples two, and this frame's. The constant weight of svgf, 0.2, leaves less than
    // four effective samples.
    const double weights2 = settings.history_weight == HistoryWeight::kConstant
                                ? std::pow(0.8, 6) + 0.04 * (std::pow(0.8, 4) + 0.64 + 1)
                                : 0.25;
    EXPECT_NEAR(out.front().channels[0](20, 20), 1 + 0.5 * std::fmin(4.0, 1 / weights2), 1e-4)
        << preset;
  }
}

TEST(Confidence, DropsTheLightOfPixelsWithoutASampleToo) {
  // The lamp was switched in the frame in which a pixel got no sample.
  for (const float brightness : {0.0f, 1.0f}) {
    std::vector<Frame> frames;
    for (int i = 0; i < 8; ++i) {
      frames.push_back(MakeWall(kWidth, kHeight, i));
      for (int c = 0; c < 3; ++c) {
        Light(&frames.back(), SignalKind::kDirectDiffuse)[c].Fill(i < 6 ? 3.0f : brightness);
      }
    }
    frames[6].confidence = Filled(0);
    frames[6].samples = Filled(1);
    frames[6].samples(20, 20) = 0;
    for (const char* preset : {"default", "svgf"}) {
      const auto out = Outputs(PresetSettings(preset).value(), frames, {"accumulated", "history"},
                               Backend::kCpu);
      // Of the first signal, that of direct diffuse light.
      const Image1& light = out[0].channels[0];
      const Image1& length = out[out.size() / 2].channels[0];
      EXPECT_EQ(length(20, 20), 1) << preset;
      EXPECT_EQ(length(10, 20), 2) << preset;
      EXPECT_NEAR(light(20, 20), light(10, 20), 1e-5) << preset;
    }
  }
}

TEST(Confidence, ASwitchedLampDoesNotLag) {
  const auto frames = [](bool with) {
    std::vector<Frame> made;
    for (int i = 0; i < 21; ++i) {
      made.push_back(MakeLamp(i, i < 20 ? 1.0f : 0.1f));
    }
    if (with) {
      made.back().confidence = Filled(0);
    }
    return made;
  };
  for (const char* preset : {"default", "svgf", "psvgf", "temporal"}) {
    const Settings settings = PresetSettings(preset).value();
    const double dark = test::MeanOf(Denoised(settings, {MakeLamp(20, 0.1f)}));
    const double with = test::MeanOf(Denoised(settings, frames(true)));
    const double without = test::MeanOf(Denoised(settings, frames(false)));
    EXPECT_NEAR(with, dark, 0.02 * dark) << preset;
    EXPECT_GT(without, 1.3 * dark) << preset;
  }
}

TEST(Confidence, LowValuesForgetWithoutStayingNoisy) {
  // After a frame of little confidence the light is averaged again as after a first frame:
  // alpha_min does not slow it down as it would a long history.
  std::vector<Frame> frames;
  for (int i = 0; i < 34; ++i) {
    frames.push_back(MakeLamp(i, i < 30 ? 1.0f : 0.1f));
  }
  frames[30].confidence = Filled(0.02f);
  const auto out = Outputs(PresetSettings("temporal").value(), frames, {"history"}, Backend::kCpu);
  ASSERT_FALSE(out.empty());
  EXPECT_NEAR(out.front().channels[0](20, 20), 4, 0.5);
}

TEST(Confidence, NanCountsAsOneAndAsABadGuide) {
  std::vector<Frame> with = BusyFrames(4);
  const Image3 expected = Denoised(Settings(), with);
  for (Frame& f : with) {
    f.confidence = Filled(1);
    f.confidence(3, 4) = kNan;
    f.confidence(30, 20) = -kNan;
  }
  Denoiser denoiser = MakeDenoiser(Settings());
  Denoiser without = MakeDenoiser(Settings());
  DenoisedFrame out;
  DenoisedFrame plain;
  for (Frame& f : with) {
    ASSERT_TRUE(denoiser.Denoise(f, &out).ok());
    f.confidence = Image1();
    ASSERT_TRUE(without.Denoise(f, &plain).ok());
    EXPECT_EQ(out.bad_guides, plain.bad_guides + 2);
  }
  EXPECT_TRUE(SameBits(out.colour, expected));
}

TEST(Confidence, ErrorsNameTheImage) {
  Denoiser denoiser = MakeDenoiser(Settings());
  DenoisedFrame out;
  Frame f = MakeWall(kWidth, kHeight);
  f.confidence = Image1(kWidth, kHeight - 1);
  const Status status = denoiser.Denoise(f, &out);
  EXPECT_EQ(status.code(), StatusCode::kInvalidArgument);
  EXPECT_THAT(status.message(), HasSubstr("'confidence' is 48x31, expected 48x32"));
}

TEST(Confidence, CpuAgreesWithTheReference) {
  for (const char* preset : {"default", "svgf", "psvgf"}) {
    const Settings settings = test::WithoutFxaa(PresetSettings(preset).value());
    Denoiser denoiser = MakeDenoiser(settings);
    test::ExpectReferencePictures(
        settings, &denoiser, 5,
        [](int i) {
          Frame f = MakeBusyFrame(kWidth, kHeight, i);
          f.confidence = AnyConfidence(kWidth, kHeight, i);
          f.reflection.depth = f.guides.depth;  // a layer of its own
          f.reflection.motion = f.guides.motion;
          return f;
        },
        [](const std::string&) {
          return test::Tolerance{2e-3, 0.004};
        },
        preset);
  }
}

TEST(Confidence, ImagesInMirrorsForgetToo) {
  const auto last = [](bool with) {
    std::vector<Frame> frames;
    for (int i = 0; i < 13; ++i) {
      Frame f = MakeWall(kWidth, kHeight, i);
      f.guides.roughness.Fill(0);
      for (int c = 0; c < 3; ++c) {
        Light(&f, SignalKind::kIndirectSpecular)[c].Fill(i < 12 ? 1.0f : 0.2f);
      }
      f.reflection.depth = Filled(12);
      f.reflection.motion = Image2(kWidth, kHeight);
      frames.push_back(std::move(f));
    }
    if (with) {
      frames.back().confidence = Filled(0);
    }
    Settings settings;
    settings.limit_history = false;  // which corrects so simple a change by itself
    return Outputs(settings, frames, {"accumulated.specular"}, Backend::kCpu)
        .front()
        .channels[0](20, 20);
  };
  EXPECT_GT(last(false), 1.5f * last(true));
}

// Light of the future.

TEST(Confidence, IsMovedToTheFrameBefore) {
  Frame next = MakeWall(kWidth, kHeight);
  next.confidence = Image1(kWidth, kHeight);
  test::FillImage(&next.confidence,
                  [](int x, int y) { return static_cast<float>(x + kWidth * y) / 2000; });
  Image2 motion(kWidth, kHeight);
  motion[0].Fill(3.25f);
  motion[1].Fill(-1.6f);
  motion[0](5, 5) = kNan;
  const FrameMotion moved = MotionTowards(Frame(), next, motion);
  EXPECT_EQ(moved.confidence(10, 10), next.confidence(13, 8));
  EXPECT_EQ(moved.confidence(5, 5), 1);           // leads nowhere
  EXPECT_EQ(moved.confidence(kWidth - 1, 8), 1);  // and out of the picture
  EXPECT_EQ(moved.confidence(8, 1), 1);
  next.confidence = Image1();
  EXPECT_TRUE(MotionTowards(Frame(), next, motion).confidence.empty());
}

TEST(Confidence, LightOfTheFutureCountsForItsShortenedLength) {
  // Four frames of light 1 up to the last one, and four of light 2 after it: both counted for the
  // same, the picture would be 1.5; the future counted for half, it is a third of the way.
  const auto frame_of = [](float light) {
    Frame f = MakeWall(kWidth, kHeight);
    for (int c = 0; c < 3; ++c) {
      Light(&f, SignalKind::kDirectDiffuse)[c].Fill(light);
    }
    return f;
  };
  for (const Backend backend : {Backend::kCpu, Backend::kReference}) {
    for (const float confidence : {1.0f, 0.5f, 0.0f}) {
      const Settings settings = PresetSettings("temporal").value();
      Denoiser backward = MakeDenoiser(settings, backend);
      FutureLight future;
      for (int i = 0; i < 4; ++i) {
        ASSERT_TRUE(backward.Accumulate(frame_of(2), &future).ok());
      }
      Frame last = frame_of(1);
      last.confidence = Filled(confidence);
      ASSERT_TRUE(backward.Accumulate(last, &future).ok());
      Denoiser forward = MakeDenoiser(settings, backend);
      DenoisedFrame out;
      for (int i = 0; i < 3; ++i) {
        ASSERT_TRUE(forward.Denoise(frame_of(1), &out).ok());
      }
      ASSERT_TRUE(forward.Denoise(frame_of(1), future, &out).ok());
      const float share = confidence / (1 + confidence);
      EXPECT_NEAR(out.colour[0](20, 20), 1 + share, 1e-4) << confidence;
    }
  }
}

TEST(Confidence, LightOfTheFutureEndsWhereALampIsSwitched) {
  // The lamp goes on in frame 6: frames before it must not receive its light.
  const auto pictures = [](bool with) {
    Result<TwoWayDenoiser> denoiser =
        TwoWayDenoiser::Create(PresetSettings("temporal").value(), Device(), {});
    EXPECT_TRUE(denoiser.ok());
    for (int i = 0; i < 12; ++i) {
      Frame f = MakeWall(kWidth, kHeight, i);
      for (int c = 0; c < 3; ++c) {
        Light(&f, SignalKind::kDirectDiffuse)[c].Fill(i < 6 ? 0.5f : 2.0f);
      }
      if (with) {
        f.confidence = Filled(i == 6 ? 0.0f : 1.0f);
      }
      EXPECT_TRUE(denoiser->Push(std::move(f), Cut::kNo).ok());
    }
    denoiser->Finish();
    std::vector<float> values;
    DenoisedFrame out;
    for (int i = 0; i < 12; ++i) {
      const Result<bool> pulled = denoiser->Pull(&out);
      EXPECT_TRUE(pulled.ok() && *pulled);
      values.push_back(out.colour[0](20, 20));
    }
    return values;
  };
  const std::vector<float> with = pictures(true);
  const std::vector<float> without = pictures(false);
  for (size_t i = 0; i < 12; ++i) {
    EXPECT_NEAR(with[i], i < 6 ? 0.5f : 2.0f, 1e-3) << i;
  }
  EXPECT_GT(without[5], 0.7f);
  EXPECT_LT(without[6], 1.8f);
}

}  // namespace
}  // namespace stillray::confidence_test
