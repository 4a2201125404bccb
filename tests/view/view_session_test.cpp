// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "view/view_session.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "stillray/quality.h"
#include "view/exact_accumulation.h"
#include "view/small_session.h"

namespace stillray::view::view_session_test {
namespace {

using ::testing::HasSubstr;

TEST(ViewSession, AStillViewGetsBetter) {
  ViewSession session = Open("builtin:cornell");
  ViewSettings settings = SmallSettings();
  const ViewFrame first = Next(settings, &session);
  EXPECT_EQ(first.number, 1u);
  EXPECT_EQ(first.pictures.size(), 2u);
  EXPECT_FALSE(first.still);
  const Image3 early = *session.Denoised().value();
  for (int i = 0; i < 30; ++i) {
    Next(settings, &session);
  }
  const Image3 late = *session.Denoised().value();
  settings.reference = true;
  Next(settings, &session);
  for (int i = 0; i < 128; ++i) {
    ASSERT_TRUE(session.RefineReference(kGoOn).ok());
  }
  EXPECT_EQ(session.reference().spp(), 128);
  const Image3& reference = *session.reference().picture();
  const double before = CompareImages(early, reference, false).value().flip;
  const double after = CompareImages(late, reference, false).value().flip;
  EXPECT_LT(after, 0.8 * before);
  EXPECT_LT(CompareImages(early, reference, false).value().flip,
            CompareImages(session.noisy(), reference, false).value().flip);
}

TEST(ViewSession, ReferencePassesAreIndependentOfEachOther) {
  ViewSession session = Open("builtin:cornell");
  ViewSettings settings = SmallSettings();
  settings.reference = true;
  Next(settings, &session);
  Next(settings, &session);
  std::vector<double> errors;
  Image3 few;
  for (int i = 0; i < 256; ++i) {
    ASSERT_TRUE(session.RefineReference(kGoOn).ok());
    if (i == 15) {
      few = *session.reference().picture();
    }
  }
  const Image3& many = *session.reference().picture();
  // 16 samples against 256: had every pass the same random numbers, both would be equal.
  EXPECT_GT(CompareImages(few, many, false).value().rel_mse, 1e-3);
}

TEST(ViewSession, TheSameCallsGiveTheSameBits) {
  std::vector<uint8_t> pixels[2];
  for (std::vector<uint8_t>& run : pixels) {
    ViewSession session = Open("builtin:lights");
    ViewSettings settings = SmallSettings();
    settings.playing = true;
    settings.rate = {1, 4};
    ViewFrame frame;
    for (int i = 0; i < 6; ++i) {
      frame = Next(settings, &session);
      settings.rate = i == 2 ? SampleRate{1, 2} : settings.rate;
    }
    run = frame.pictures[0].pixels;
  }
  EXPECT_EQ(pixels[0], pixels[1]);
}

TEST(ViewSession, FewerSamplesThanPixelsFillInOverACycle) {
  ViewSession session = Open("builtin:cornell");
  ViewSettings settings = SmallSettings();
  settings.rate = {1, 8};
  settings.panes = {"samples"};
  Image1 sum(96, 64);
  for (int n = 0; n < 8; ++n) {
    Next(settings, &session);
    const std::vector<Image1> samples = session.Values("samples").value();
    for (int y = 0; y < 64; ++y) {
      for (int x = 0; x < 96; ++x) {
        sum(x, y) += samples[0](x, y);
      }
    }
  }
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 96; ++x) {
      ASSERT_EQ(sum(x, y), 1) << x << " " << y;
    }
  }
}

TEST(ViewSession, AMovedCameraSeesSomethingElse) {
  ViewSession session = Open("builtin:cornell");
  ViewSettings settings = SmallSettings();
  const ViewFrame before = Next(settings, &session);
  settings.free_camera = true;
  settings.pose = Orbit(before.pose, 0.4f, 0.1f);
  const ViewFrame after = Next(settings, &session);
  EXPECT_FALSE(after.still);
  EXPECT_EQ(after.pose, settings.pose);
  EXPECT_GT(MeanDifference(before.pictures[0], after.pictures[0]), 5);
  // Motion vectors follow the camera.
  const std::vector<Image1> motion = session.Values("motion").value();
  EXPECT_GT(std::abs(motion[0](48, 32)), 1);
}

TEST(ViewSession, TheFreeCameraAtTheFilesPlaceSeesTheSame) {
  ViewSession session = Open("builtin:cornell");
  ViewSettings settings = SmallSettings();
  const ViewFrame file = Next(settings, &session);
  settings.free_camera = true;
  settings.pose = file.pose;
  const ViewFrame free = Next(settings, &session);
  EXPECT_TRUE(free.still);
}

TEST(ViewSession, TimePassesSeeksAndWraps) {
  ViewSession session = Open("builtin:lights");
  ViewSettings settings = SmallSettings();
  const ViewFrame first = Next(settings, &session);
  EXPECT_GT(first.length, 0);
  EXPECT_EQ(first.seconds, 0);
  settings.playing = true;
  settings.fps = 10;
  settings.speed = 2;
  EXPECT_NEAR(Next(settings, &session).seconds, 0.2, 1e-9);
  settings.seek = 1;
  settings.seek_seconds = first.length - 0.1;
  EXPECT_NEAR(Next(settings, &session).seconds, first.length - 0.1, 1e-9);
  EXPECT_NEAR(Next(settings, &session).seconds, 0.1, 1e-9);
  settings.speed = -2;
  EXPECT_NEAR(Next(settings, &session).seconds, first.length - 0.1, 1e-9);
  settings.playing = false;
  EXPECT_NEAR(Next(settings, &session).seconds, first.length - 0.1, 1e-9);
}

TEST(ViewSession, LightsMoveAtASpeedOfTheirOwn) {
  ViewSession session = Open("builtin:lights");
  EXPECT_TRUE(session.has_moving_lights());
  ViewSettings settings = SmallSettings();
  settings.width = 48;
  settings.height = 32;
  settings.playing = true;
  settings.fps = 10;
  settings.speed = 0;
  settings.light_speed = 2;
  const ViewFrame first = Next(settings, &session);
  const ViewFrame second = Next(settings, &session);
  EXPECT_EQ(second.seconds, 0);
  EXPECT_NEAR(second.light_seconds, 0.2, 1e-9);
  EXPECT_FALSE(second.still);
  EXPECT_EQ(second.pose, first.pose) << "the file's camera belongs to the rest";
  settings.speed = 1;
  settings.light_speed.reset();
  settings.seek = 1;
  settings.seek_seconds = 1;
  const ViewFrame both = Next(settings, &session);
  EXPECT_EQ(both.seconds, 1);
  EXPECT_EQ(both.light_seconds, 1);
}

/// Each clock moves its own part, from a fixed camera: surfaces by their depth, light by the
/// picture.
TEST(ViewSession, EachClockMovesItsOwn) {
  struct Seen {
    Image1 depth;
    Image3 light;
  };
  const auto after_a_second = [](double speed, double light_speed) {
    ViewSession session = Open("builtin:lights");
    ViewSettings settings = SmallSettings();
    settings.denoise.temporal = false;
    settings.denoise.antialias = Antialias::kOff;
    settings.rate = {4, 1};
    settings.pose = Next(settings, &session).pose;
    settings.free_camera = true;
    settings.playing = true;
    settings.fps = 1;
    settings.speed = speed;
    settings.light_speed = light_speed;
    Next(settings, &session);
    return Seen{session.Values("depth").value()[0], session.noisy()};
  };
  const auto moved_pixels = [](const Image1& a, const Image1& b) {
    int count = 0;
    for (int y = 0; y < a.height(); ++y) {
      for (int x = 0; x < a.width(); ++x) {
        count += std::abs(a(x, y) - b(x, y)) > 0.01f * b(x, y) ? 1 : 0;
      }
    }
    return count;
  };
  const auto unlike = [](const Image3& a, const Image3& b) {
    return CompareImages(a, b, false).value().rel_mse;
  };
  const Seen still = after_a_second(0, 0);
  const Seen lights = after_a_second(0, 1);
  const Seen objects = after_a_second(1, 0);
  const Seen both = after_a_second(1, 1);
  // The same random numbers: pictures differ only by the motion.
  EXPECT_GT(unlike(lights.light, still.light), 1e-3);
  EXPECT_GT(unlike(both.light, objects.light), 1e-3);
  EXPECT_GT(moved_pixels(objects.depth, still.depth), 60);
  EXPECT_LT(moved_pixels(lights.depth, still.depth), moved_pixels(objects.depth, still.depth) / 4);
  EXPECT_LT(moved_pixels(both.depth, objects.depth), moved_pixels(both.depth, still.depth) / 4);
}

TEST(ViewSession, FilledGuidesHaveNoHoles) {
  ViewSession session = Open("builtin:cornell");
  ViewSettings settings = SmallSettings();
  settings.rate = {1, 16};
  settings.render.guides = GuideCoverage::kSparse;
  settings.panes = {"filled.depth", "filled.normal", "depth"};
  for (int n = 0; n < 20; ++n) {
    Next(settings, &session);
    const Image1 filled = session.Values("filled.depth").value()[0];
    const Image1 raw = session.Values("depth").value()[0];
    int holes = 0;
    for (int y = 0; y < raw.height(); ++y) {
      for (int x = 0; x < raw.width(); ++x) {
        holes += raw(x, y) == 0 ? 1 : 0;
        ASSERT_GT(filled(x, y), 0) << x << " " << y << " in frame " << n;
        ASSERT_TRUE(raw(x, y) == 0 || raw(x, y) == filled(x, y)) << "what is known stays";
      }
    }
    EXPECT_GT(holes, raw.width() * raw.height() * 3 / 4);
  }
  // With guides everywhere both are the same.
  settings.render.guides = GuideCoverage::kFull;
  Next(settings, &session);
  EXPECT_EQ(session.Values("filled.depth").value()[0](10, 10),
            session.Values("depth").value()[0](10, 10));
}

TEST(ViewSession, ChoosingWhatToOrbitAroundMovesNothing) {
  ViewSession session = Open("builtin:cornell");
  ViewSettings settings = SmallSettings();
  const ViewFrame first = Next(settings, &session);
  settings.free_camera = true;
  settings.pose = OrbitAround(first.pose, 0.2f, 0.3f, 1.5f, 2.0f);
  EXPECT_TRUE(Next(settings, &session).still);
}

TEST(ViewSession, TheCameraOrbitsAtItsSpeedAndRadius) {
  ViewSession session = Open("builtin:cornell");
  ViewSettings settings = SmallSettings();
  const ViewPose start = Next(settings, &session).pose;
  settings.orbiting = true;
  settings.orbit_speed = 45;
  settings.fps = 30;
  settings.orbit_radius = 3;
  settings.free_camera = true;
  settings.pose = start;
  ViewFrame frame;
  for (int i = 0; i < 4; ++i) {
    frame = Next(settings, &session);
  }
  // Four steps of 1.5 degrees.
  EXPECT_NEAR(std::remainder(frame.pose.yaw - start.yaw, 6.2831853f), 0.1047198f, 1e-5f);
  EXPECT_NEAR(glm::length(frame.pose.position - start.Focus()), 3, 1e-4f);
  EXPECT_FALSE(frame.still);
  settings.orbiting = false;
  settings.pose = frame.pose;
  EXPECT_EQ(Next(settings, &session).pose, frame.pose);
}

TEST(ViewSession, ResizingGoesOnAtTheNewSize) {
  ViewSession session = Open("builtin:cornell");
  ViewSettings settings = SmallSettings();
  Next(settings, &session);
  settings.width = 50;
  settings.height = 31;
  const ViewFrame frame = Next(settings, &session);
  EXPECT_EQ(frame.width, 50);
  EXPECT_EQ(frame.height, 31);
  EXPECT_EQ(frame.pictures[1].pixels.size(), 50u * 31 * 3);
  settings.width = 1;
  settings.height = 1;
  EXPECT_EQ(Next(settings, &session).width, 16);
}

TEST(ViewSession, EveryPresetAndGroupingWorksInAnyOrder) {
  ViewSession session = Open("builtin:spheres");
  ViewSettings settings = SmallSettings();
  settings.inspect = true;
  for (const std::string_view preset : PresetNames()) {
    for (const char* signals : {"split", "single", "direct_indirect"}) {
      settings.denoise = PresetSettings(preset).value();
      ASSERT_TRUE(SetParameter(&settings.denoise, "signals", signals).ok());
      settings.panes = {"denoised", "variance.direct"};
      const ViewFrame frame = Next(settings, &session);
      EXPECT_GT(frame.inspected.size(), 10u) << preset << " " << signals;
    }
  }
}

TEST(ViewSession, ContradictingSettingsAreNamedAndChangeNothing) {
  ViewSession session = Open("builtin:cornell");
  ViewSettings settings = SmallSettings();
  Next(settings, &session);
  settings.denoise.feedback = 7;
  ViewFrame frame;
  const Status status = session.RenderNext(settings, 0, kGoOn, &frame);
  EXPECT_EQ(status.code(), StatusCode::kInvalidArgument);
  EXPECT_THAT(status.message(), HasSubstr("feedback"));
  EXPECT_EQ(Next(SmallSettings(), &session).number, 2u);
}

TEST(ViewSession, AFrameGivenUpLeavesTheHistoryAlone) {
  ViewSession session = Open("builtin:cornell");
  const ViewSettings settings = SmallSettings();
  Next(settings, &session);
  ViewFrame frame;
  const Status status = session.RenderNext(
      settings, 0, [](double) { return false; }, &frame);
  EXPECT_EQ(status.code(), StatusCode::kCancelled);
  const ViewFrame next = Next(settings, &session);
  EXPECT_EQ(next.number, 2u);
  EXPECT_TRUE(next.still);
}

TEST(ViewSession, TellsTheDepthUnderAClick) {
  ViewSession session = Open("builtin:cornell");
  ViewSettings settings = SmallSettings();
  settings.focus = 3;
  settings.focus_x = 0.5f;
  settings.focus_y = 0.5f;
  const ViewFrame frame = Next(settings, &session);
  EXPECT_EQ(frame.focus, 3u);
  EXPECT_FLOAT_EQ(frame.focus_depth, session.Values("depth").value()[0](48, 32));
}

TEST(ViewSession, AdaptsItsRateToTheTarget) {
  ViewSession session = Open("builtin:cornell");
  ViewSettings settings = SmallSettings();
  settings.auto_rate = true;
  settings.rate = {1, 16};
  settings.target_ms = 4000;  // far more than these frames need
  ViewFrame frame;
  for (int i = 0; i < 12; ++i) {
    frame = Next(settings, &session);
  }
  EXPECT_GE(frame.rate.value(), 4.0 / 16);
}

/// Settings of a window on a machine that is always too slow: samples, resolution and filter are
/// adaptive. The plan there does not depend on measured times.
ViewSettings SlowMachine() {
  ViewSettings settings = SmallSettings();
  settings.panes = {"denoised"};
  settings.auto_rate = true;
  settings.auto_scale = true;
  settings.target_ms = 1e-6;
  return settings;
}

TEST(ViewSession, AMovingViewTakesTheFastFilterAndAStillOneRefines) {
  ViewSession session = Open("builtin:cornell");
  ViewSettings settings = SlowMachine();
  settings.free_camera = true;
  settings.pose = Next(SmallSettings(), &session).pose;
  ViewFrame frame;
  for (int i = 0; i < 30; ++i) {
    settings.pose = Orbit(settings.pose, 0.01f, 0);
    frame = Next(settings, &session);
  }
  EXPECT_TRUE(frame.fast_filter);
  EXPECT_FALSE(session.refines());
  EXPECT_EQ(session.Values("depth").value()[0].width(), frame.width);
  for (int i = 0; i < RateControl::kFramesToRefine; ++i) {
    frame = Next(settings, &session);
  }
  EXPECT_TRUE(session.refines());
  EXPECT_FALSE(frame.fast_filter);
  EXPECT_EQ(frame.width, 96);
  const double first = frame.samples;
  EXPECT_EQ(first, frame.rate.value()) << "another filter begins with a history of its own";
  frame = Next(settings, &session);
  EXPECT_EQ(frame.samples, first + frame.rate.value());
}

/// The displayed picture remains when the filter or the resolution changes.
TEST(ViewSession, AChangeOfFilterOrResolutionKeepsThePicture) {
  ViewSession session = Open("builtin:cornell");
  ViewSettings settings = SmallSettings();
  settings.panes = {"denoised"};
  settings.rate = {4, 1};
  ViewFrame frame;
  for (int i = 0; i < 12; ++i) {
    frame = Next(settings, &session);
  }
  const Rgb8Image before = frame.pictures[0];
  settings.denoise = PresetSettings("psvgf").value();
  settings.rate = {1, 128};
  settings.render.guides = GuideCoverage::kSparse;
  const Rgb8Image fast = Next(settings, &session).pictures[0];
  EXPECT_LT(MeanDifference(before, fast), 4) << "from 1/128 sample alone it would be blurred";
  settings.scale = 0.5f;
  frame = Next(settings, &session);
  ASSERT_EQ(frame.width, 48);
  Rgb8Image half = {48, 32, {}};
  for (int y = 0; y < 32; ++y) {
    for (int x = 0; x < 48; ++x) {
      for (int c = 0; c < 3; ++c) {
        half.pixels.push_back(before.pixels[(static_cast<size_t>(2 * y) * 96 + 2 * x) * 3 + c]);
      }
    }
  }
  EXPECT_LT(MeanDifference(half, frame.pictures[0]), 8);
  ViewSession fresh = Open("builtin:cornell");
  EXPECT_GT(MeanDifference(half, Next(settings, &fresh).pictures[0]), 12);
}

/// The first frame at full resolution is given up since the camera moves on: the moving picture
/// still has its history.
TEST(ViewSession, ARefiningFrameGivenUpLeavesTheMovingPictureAsItIs) {
  ViewSession session = Open("builtin:cornell");
  ViewSettings settings = SlowMachine();
  settings.free_camera = true;
  settings.pose = Next(SmallSettings(), &session).pose;
  ViewFrame frame;
  for (int i = 0; i < 30; ++i) {
    settings.pose = Orbit(settings.pose, 0.001f, 0);
    frame = Next(settings, &session);
  }
  for (int i = 1; i < RateControl::kFramesToRefine; ++i) {
    frame = Next(settings, &session);
  }
  ViewFrame dropped;
  EXPECT_EQ(session
                .RenderNext(
                    settings, 0, [](double) { return false; }, &dropped)
                .code(),
            StatusCode::kCancelled);
  EXPECT_TRUE(session.refines());
  settings.pose = Orbit(settings.pose, 0.001f, 0);
  const ViewFrame next = Next(settings, &session);
  EXPECT_TRUE(next.fast_filter);
  ASSERT_EQ(next.width, frame.width);
  EXPECT_LT(MeanDifference(frame.pictures[0], next.pictures[0]), 3);
}

/// The label used to keep counting after the history had restarted.
TEST(ViewSession, SamplesAreThoseOfTheHistory) {
  ViewSession session = Open("builtin:cornell");
  ViewSettings settings = SmallSettings();
  for (int i = 0; i < 5; ++i) {
    Next(settings, &session);
  }
  EXPECT_EQ(Next(settings, &session).samples, 6);
  SetExactAccumulation(true, settings.denoise, &settings.denoise);
  EXPECT_EQ(Next(settings, &session).samples, 1);
  EXPECT_EQ(Next(settings, &session).samples, 2);
  settings.denoise.sigma_l = 2;
  EXPECT_EQ(Next(settings, &session).samples, 3) << "this one keeps the history";
  settings.scale = 0.5f;
  EXPECT_EQ(Next(settings, &session).samples, 1);
  settings.denoise = PresetSettings("eaw").value();
  EXPECT_FALSE(Next(settings, &session).temporal);
  settings.denoise = PresetSettings("temporal").value();
  EXPECT_EQ(Next(settings, &session).samples, 1);
}

/// Frames 1 to n of a view at rest, the last one's picture.
Rgb8Image AtRest(ViewSettings settings, bool converges, int frames) {
  settings.still_converges = converges;
  ViewSession session = Open("builtin:cornell");
  ViewFrame frame;
  for (int i = 0; i < frames; ++i) {
    frame = Next(settings, &session);
  }
  EXPECT_EQ(frame.samples, frames) << "no history is lost";
  return frame.pictures[0];
}

TEST(ViewSession, AStillViewWeighsAllSamplesOnceNothingHasMoved) {
  const ViewSettings settings = SmallSettings();
  constexpr int kMoving = RateControl::kFramesToRefine;
  EXPECT_EQ(AtRest(settings, true, kMoving).pixels, AtRest(settings, false, kMoving).pixels);
  EXPECT_NE(AtRest(settings, true, 24).pixels, AtRest(settings, false, 24).pixels);
}

TEST(ViewSession, OtherViewsShowTheSettingsAsTheyAre) {
  ViewSettings settings = SmallSettings();
  settings.panes = {"denoised", "temporal"};
  EXPECT_EQ(AtRest(settings, true, 24).pixels, AtRest(settings, false, 24).pixels);
  settings.panes = {"denoised"};
  settings.inspect = true;
  EXPECT_EQ(AtRest(settings, true, 24).pixels, AtRest(settings, false, 24).pixels);
}

/// The frame that moves has the weights of the settings again, on the history of all samples.
TEST(ViewSession, AViewThatMovesAgainKeepsItsHistory) {
  ViewSettings settings = SmallSettings();
  ViewSession session = Open("builtin:cornell");
  ViewFrame frame;
  for (int i = 0; i < 24; ++i) {
    frame = Next(settings, &session);
  }
  settings.free_camera = true;
  settings.pose = Orbit(frame.pose, 0.001f, 0);
  const ViewFrame moved = Next(settings, &session);
  EXPECT_FALSE(moved.still);
  EXPECT_LT(MeanDifference(frame.pictures[0], moved.pictures[0]), 1.5);
}

TEST(LoadForView, NamesWhatIsWrong) {
  const auto quiet = [](const LoadPhase&) { return true; };
  EXPECT_EQ(LoadForView({"no/such.glb", ""}, SmallSettings(), quiet).status().code(),
            StatusCode::kNotFound);
  const Result<LoadedScene> bad =
      LoadForView({"builtin:cornell", "no/such.hdr"}, SmallSettings(), quiet);
  ASSERT_FALSE(bad.ok());
  EXPECT_THAT(bad.status().message(), HasSubstr("environment"));
  EXPECT_THAT(bad.status().message(), HasSubstr("no/such.hdr"));
}

}  // namespace
}  // namespace stillray::view::view_session_test
