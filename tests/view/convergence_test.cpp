// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Quality over time: a still view converges, a moving one stays usable.
#include <cmath>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "denoise/plan.h"
#include "stillray/quality.h"
#include "view/exact_accumulation.h"
#include "view/small_session.h"
#include "view/view_session.h"

namespace stillray::view::convergence_test {
namespace {

ViewSettings SmallSettings(const std::string& preset, const SampleRate& rate) {
  ViewSettings settings = SettingsOfSize(120, 68);
  settings.rate = rate;
  settings.wall_clock = false;
  settings.render.bounces = 2;
  settings.denoise = PresetSettings(preset).value();
  settings.still_converges = false;
  return settings;
}

LoadedScene Load(const std::string& scene, const ViewSettings& settings) {
  return std::move(
      LoadForView({scene, ""}, settings, [](const LoadPhase&) { return true; }).value());
}

/// Squared error relative to the reference's mean square: fireflies and dark corners count as they
/// are.
double Error(const Image3& picture, const Image3& reference) {
  double error = 0;
  double power = 0;
  for (int c = 0; c < 3; ++c) {
    for (int y = 0; y < reference.height(); ++y) {
      for (int x = 0; x < reference.width(); ++x) {
        const double d = picture[c](x, y) - reference[c](x, y);
        error += d * d;
        power += double{reference[c](x, y)} * reference[c](x, y);
      }
    }
  }
  return error / power;
}

Image3 Converged(const std::string& scene, const ViewSettings& settings, int spp) {
  LoadedScene loaded = Load(scene, settings);
  const Scene& s = *loaded.scene;
  RenderMoment moment;
  const ViewPose pose = settings.free_camera ? settings.pose : FilePose(s, SceneBounds(s, 0), 0, 0);
  moment.pose = CameraPose{ToMatrix(pose), pose.yfov};
  moment.seconds = moment.previous_seconds = settings.seek_seconds;
  Image3 picture;
  EXPECT_TRUE(loaded.renderer->RenderReference(moment, spp, &picture, {}).ok());
  return picture;
}

/// Errors of the still view when 1, 4, 16 and 64 samples per pixel have arrived.
std::vector<double> ErrorsOverTime(const ViewSettings& settings, const Image3& reference) {
  ViewSession session(Load("builtin:cornell", settings));
  std::vector<double> errors;
  ViewFrame frame;
  double next = 1;
  for (int n = 1; n <= 64 * settings.rate.cycle; ++n) {
    EXPECT_TRUE(session.RenderNext(settings, 0, kGoOn, &frame).ok());
    if (n >= next * settings.rate.cycle) {
      errors.push_back(Error(*session.Denoised().value(), reference));
      next *= 4;
    }
  }
  return errors;
}

std::string Text(const std::vector<double>& errors) {
  std::string text;
  for (const double error : errors) {
    text += fmt::format(" {:.5f}", error);
  }
  return text;
}

struct Errors {
  std::vector<double> preset;
  std::vector<double> still;  ///< with equal weights once nothing moves
  std::vector<double> exact;
};

Errors ErrorsOf(const std::string& preset, const SampleRate& rate,
                int candidates = RenderSettings().light_candidates) {
  ViewSettings settings = SmallSettings(preset, rate);
  settings.render.light_candidates = candidates;
  const Image3 reference = Converged("builtin:cornell", settings, 512);
  Errors errors;
  errors.preset = ErrorsOverTime(settings, reference);
  settings.still_converges = true;
  errors.still = ErrorsOverTime(settings, reference);
  settings.still_converges = false;
  SetExactAccumulation(true, settings.denoise, &settings.denoise);
  EXPECT_TRUE(AccumulatesExactly(settings.denoise));
  errors.exact = ErrorsOverTime(settings, reference);
  std::printf("%s: as the preset has it%s; while still%s; exactly%s\n", preset.c_str(),
              Text(errors.preset).c_str(), Text(errors.still).c_str(), Text(errors.exact).c_str());
  return errors;
}

void ExpectToFall(const std::vector<double>& errors) {
  for (size_t i = 1; i < errors.size(); ++i) {
    EXPECT_LT(errors[i], errors[i - 1]) << i;
  }
}

/// limit_history expects what jittered points change: histories stay long.
TEST(StillView, DefaultFallsAlmostAsFarAsExactAccumulation) {
  for (const int candidates : {1, RenderSettings().light_candidates}) {
    SCOPED_TRACE(candidates);
    const Errors errors = ErrorsOf("default", {1, 1}, candidates);
    ExpectToFall(errors.preset);
    ExpectToFall(errors.exact);
    ExpectToFall(errors.still);
    EXPECT_LT(errors.preset.back(), 0.18 * errors.preset.front());
    EXPECT_LT(errors.preset.back(), 1.3 * errors.exact.back());
    EXPECT_LT(errors.exact.back(), 0.92 * errors.preset.back());
    EXPECT_LT(errors.still.back(), 0.92 * errors.preset.back());
  }
}

/// svgf gives each frame the same weight, whatever came before.
TEST(StillView, SvgfConvergesOnceNothingMoves) {
  const Errors errors = ErrorsOf("svgf", {1, 1});
  ExpectToFall(errors.still);
  EXPECT_LT(errors.still.back(), 0.5 * errors.preset.back());
}

TEST(StillView, EqualWeightsKeepTheHistory) {
  for (const std::string_view name : PresetNames()) {
    const Settings preset = PresetSettings(name).value();
    const Settings equal = WithEqualWeights(preset);
    // The history of blended feedback is seeded.
    EXPECT_EQ(NeedsNewHistory(preset, equal), name == "psvgf") << name;
    EXPECT_EQ(equal.alpha_min, 0) << name;
    EXPECT_EQ(equal.history_weight, HistoryWeight::kAge) << name;
    EXPECT_TRUE(ValidateSettings(equal).ok()) << name;
  }
  Settings blended = PresetSettings("svgf").value();
  blended.feedback_when = FeedbackWhen::kBlend;
  EXPECT_FALSE(NeedsNewHistory(blended, WithEqualWeights(blended)));
}

/// Neither the change to equal weights nor the one back shows the noise of a new history.
TEST(StillView, BlendedFeedbackGoesOnFromTheShownPicture) {
  ViewSettings settings = SmallSettings("psvgf", {1, 1});
  settings.still_converges = true;
  ViewSession session(Load("builtin:cornell", settings));
  std::vector<Rgb8Image> pictures;
  for (int n = 0; n < 16; ++n) {
    ViewFrame frame;
    ASSERT_TRUE(session.RenderNext(settings, 0, kGoOn, &frame).ok());
    if (n == 14) {
      settings.free_camera = true;
      settings.pose = Orbit(frame.pose, 0.0005f, 0);
    }
    pictures.push_back(frame.pictures[0]);
  }
  for (size_t n = RateControl::kFramesToRefine; n < pictures.size(); ++n) {
    EXPECT_LT(MeanDifference(pictures[n], pictures[n - 1]),
              0.5 * MeanDifference(pictures[1], pictures[0]))
        << n;
  }
}

/// psvgf as published uses the noise of single frames and feeds filtered light back: blur cancels
/// the gain of more samples, and its error has a high floor. Exact accumulation converges.
TEST(StillView, PsvgfConvergesWithExactAccumulation) {
  const Errors errors = ErrorsOf("psvgf", {1, 2});
  ExpectToFall(errors.exact);
  EXPECT_LT(errors.exact.back(), 0.1 * errors.exact.front());
  EXPECT_LT(errors.exact.back(), 0.1 * errors.preset.back());
  EXPECT_LT(errors.still.back(), 0.1 * errors.preset.back());
  // The floor of the preset is reached and held.
  const size_t last = errors.preset.size() - 1;
  EXPECT_LT(errors.preset[last], 0.15);
  EXPECT_LT(errors.preset[last], 1.25 * errors.preset[last - 1]);
}

/// Camera in orbit, lamp in motion, one path for 16 pixels.
TEST(UnderMotion, ThePictureStaysUsable) {
  ViewSettings settings = SmallSettings("psvgf", {1, 16});
  settings.playing = true;
  settings.fps = 30;
  ViewSession session(Load("builtin:lights", settings));
  ViewFrame frame;
  ASSERT_TRUE(session.RenderNext(settings, 0, kGoOn, &frame).ok());
  settings.free_camera = true;
  settings.pose = frame.pose;
  for (const bool sparse : {false, true}) {
    settings.render.guides = sparse ? GuideCoverage::kSparse : GuideCoverage::kFull;
    for (int n = 0; n < 24; ++n) {
      settings.pose = Orbit(settings.pose, sparse ? -0.006f : 0.006f, 0);
      ASSERT_TRUE(session.RenderNext(settings, 0, kGoOn, &frame).ok());
      const Image3& c = *session.Denoised().value();
      int holes = 0;
      for (int y = 0; y < frame.height; ++y) {
        for (int x = 0; x < frame.width; ++x) {
          const float sum = c[0](x, y) + c[1](x, y) + c[2](x, y);
          ASSERT_TRUE(std::isfinite(sum)) << "frame " << n << " at " << x << " " << y;
          holes += sum > 0 ? 0 : 1;
        }
      }
      // Until every pixel has had a path, a pixel may have no neighbour with light.
      EXPECT_LE(holes, !sparse && n < settings.rate.cycle ? 3 : 0) << "in frame " << n;
    }
    ViewSettings still = settings;
    still.seek_seconds = frame.seconds;
    const Image3 reference = Converged("builtin:lights", still, 256);
    const double raw = Error(session.noisy(), reference);
    const double clean = Error(*session.Denoised().value(), reference);
    const double raw_flip = CompareImages(session.noisy(), reference, false).value().flip;
    const double clean_flip =
        CompareImages(*session.Denoised().value(), reference, false).value().flip;
    std::printf("%s guides: error %.4f raw, %.4f denoised; FLIP %.4f raw, %.4f denoised\n",
                sparse ? "sparse" : "full", raw, clean, raw_flip, clean_flip);
    EXPECT_LT(clean, raw / 3);
    EXPECT_LT(clean_flip, raw_flip / 2.2);
  }
}

}  // namespace
}  // namespace stillray::view::convergence_test
