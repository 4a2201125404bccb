// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "view/views.h"

#include <cmath>
#include <functional>
#include <set>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "view/colour_maps.h"
#include "view/small_session.h"
#include "view/view_session.h"

namespace stillray::view::views_test {
namespace {

ViewSettings MovingSettings() {
  ViewSettings settings = SettingsOfSize(64, 48);
  settings.wall_clock = false;
  settings.playing = true;
  settings.reference = true;
  return settings;
}

TEST(Views, NamesAreUniqueAndCoverEveryOutput) {
  const Settings settings;
  std::set<std::string> names;
  std::set<std::string> outputs;
  for (const ViewInfo& view : ListViews(settings)) {
    EXPECT_TRUE(names.insert(view.name).second) << view.name;
    outputs.insert(view.outputs.begin(), view.outputs.end());
  }
  for (const std::string& output : Denoiser::OutputNames(settings)) {
    EXPECT_EQ(outputs.count(output), 1u) << output;
  }
  for (const char* name :
       {"denoised", "noisy", "reference", "depth", "normal", "albedo", "motion", "id", "roughness",
        "samples", "emission", "background", "direct_diffuse", "indirect_specular", "atrous5",
        "relative_noise.direct", "history.specular"}) {
    EXPECT_EQ(names.count(name), 1u) << name;
  }
}

/// Views of light that comes through glass or blended surfaces.
bool IsOfTransmission(const std::string& view) {
  return view.find("transmission") != std::string::npos;
}

/// Every view of a moving scene shows something, and no two of them the same.
/// \param shown  views to try
void ExpectOwnPictures(const std::string& scene,
                       const std::function<bool(const ViewInfo&)>& shown) {
  ViewSession session(std::move(
      LoadForView({scene, ""}, MovingSettings(), [](const LoadPhase&) { return true; }).value()));
  ViewSettings settings = MovingSettings();
  std::set<std::string> pictures;
  // Nothing of these scenes is known to be plain but these; glass balls have no direct light, and
  // indirect light does not change by more than its noise.
  const std::set<std::string> may_be_plain = {"disocclusion", "background", "emission",
                                              "direct_transmission", "ratio.indirect"};
  // Frames with guides everywhere have nothing to fill.
  const std::string same = "filled.";
  for (const ViewInfo& view : ListViews(settings.denoise)) {
    if (!shown(view)) {
      continue;
    }
    settings.panes = {view.name};
    ViewFrame frame;
    ASSERT_TRUE(session
                    .RenderNext(
                        settings, 0, [](double) { return true; }, &frame)
                    .ok());
    ASSERT_EQ(frame.panes[0], view.name);
    const std::vector<uint8_t>& pixels = frame.pictures[0].pixels;
    const std::set<uint8_t> values(pixels.begin(), pixels.end());
    if (may_be_plain.count(view.name) == 0 && view.name != "reference" && view.name != "samples") {
      const bool has_few = view.name == "world_grid" || view.name == "ratio.specular";
      EXPECT_GT(values.size(), has_few ? 1u : 3u) << view.name;
      EXPECT_TRUE(view.name.starts_with(same) ||
                  pictures.insert(std::string(pixels.begin(), pixels.end())).second)
          << view.name << " shows what another one shows";
    }
  }
}

TEST(Views, EveryViewShowsItsOwnPicture) {
  ExpectOwnPictures("builtin:lights",
                    [](const ViewInfo& view) { return !IsOfTransmission(view.name); });
}

TEST(Views, GlassIsShownInTheViewsOfTransmission) {
  ExpectOwnPictures("builtin:mirrors", [](const ViewInfo& view) {
    return IsOfTransmission(view.name) && !view.name.starts_with("limit") &&
           !view.name.starts_with("ratio");
  });
}

/// A point at known coordinates, seen by a camera that has moved sideways: by hand.
TEST(WorldViews, PositionAndMotionAreThoseOfTheGeometry) {
  Frame frame;
  frame.width = frame.height = 4;
  frame.guides.depth = Image1(4, 4);
  frame.guides.motion = Image2(4, 4);
  frame.guides.depth(3, 1) = 5;
  frame.guides.motion[0](3, 1) = 1.25f;
  CameraPose pose;
  pose.yfov = 2 * std::atan(1.0f);  // a pixel at distance 1 is 0.5 wide
  pose.world_from_camera[3] = {10, 20, 30, 1};
  CameraPose before = pose;
  before.world_from_camera[3] = {11, 20, 30, 1};
  const WorldViews views = MakeWorldViews(frame, pose, before);
  EXPECT_NEAR(views.position[0](3, 1), 10 + 0.75 * 5, 1e-4);
  EXPECT_NEAR(views.position[1](3, 1), 20 + 0.25 * 5, 1e-4);
  EXPECT_NEAR(views.position[2](3, 1), 30 - 5, 1e-4);
  // The camera came from the right by 1: what stands still was 1 / 5 / 0.5 pixels further left.
  EXPECT_NEAR(views.object_motion[0](3, 1), 1.25 + 0.4, 1e-4);
  EXPECT_NEAR(views.object_motion[1](3, 1), 0, 1e-5);
  EXPECT_EQ(views.position[0](0, 0), 0) << "no surface";
  EXPECT_NEAR(views.object_motion[0](0, 0), 0, 1e-6) << "the sky is infinitely far away";
  frame.guides.motion = Image2();
  EXPECT_TRUE(MakeWorldViews(frame, pose, before).position[0].empty());
}

/// While the camera moves through a scene in which nothing else does, nothing moves by itself, and
/// every point keeps its place.
TEST(WorldViews, AStillSceneDoesNotMove) {
  ViewSettings settings = SmallSettings();
  settings.panes = {"object_motion", "position", "motion"};
  ViewSession session = Open("builtin:cornell");
  ViewFrame frame = Next(settings, &session);
  settings.free_camera = true;
  settings.pose = Orbit(frame.pose, 0.05f, 0.02f);
  Next(settings, &session);
  const std::vector<Image1> own = session.Values("object_motion").value();
  const std::vector<Image1> motion = session.Values("motion").value();
  const std::vector<Image1> position = session.Values("position").value();
  ASSERT_EQ(own.size(), 2u);
  ASSERT_EQ(position.size(), 3u);
  float largest = 0;
  for (int y = 0; y < own[0].height(); ++y) {
    for (int x = 0; x < own[0].width(); ++x) {
      ASSERT_LT(std::hypot(own[0](x, y), own[1](x, y)), 0.02f) << x << " " << y;
      largest = std::max(largest, std::hypot(motion[0](x, y), motion[1](x, y)));
    }
  }
  EXPECT_GT(largest, 1);
}

TEST(Views, WhatIsNotThereIsGreyAndHasNoValues) {
  Frame frame;
  frame.width = 4;
  frame.height = 3;
  const DenoisedFrame denoised;
  const Image3 noisy(4, 3);
  const Settings settings;
  const ViewSources sources = {&frame, &denoised, &noisy, nullptr, &settings};
  const std::vector<ViewInfo> views = ListViews(settings);
  for (const char* name :
       {"reference", "depth", "id", "variance.direct", "relative_noise.direct", "denoised"}) {
    const ViewInfo& view = *FindView(views, name);
    EXPECT_TRUE(ViewValues(view, sources).empty()) << name;
    EXPECT_TRUE(ViewValuesAt(view, sources, 1, 1).empty()) << name;
    ViewRange range;
    EXPECT_EQ(ViewPicture(view, sources, &range).pixels, std::vector<uint8_t>(36, 40)) << name;
    EXPECT_EQ(range.top, 0) << name;
  }
  EXPECT_EQ(FindView(views, "no such view"), nullptr);
}

/// Motion of a few thousandths of a pixel was a black picture.
TEST(Views, SlowMotionIsSeenOnItsOwnScale) {
  Frame frame;
  frame.width = 8;
  frame.height = 8;
  frame.guides.motion = Image2(8, 8);
  for (int y = 0; y < 8; ++y) {
    for (int x = 4; x < 8; ++x) {
      frame.guides.motion[0](x, y) = 0.003f;
    }
  }
  const DenoisedFrame denoised;
  const Image3 noisy(8, 8);
  const Settings settings;
  const ViewSources sources = {&frame, &denoised, &noisy, nullptr, &settings};
  ViewRange range;
  const Rgb8Image picture = ViewPicture(*FindView(ListViews(settings), "motion"), sources, &range);
  EXPECT_EQ(range.top, 1.0f / 256);
  EXPECT_STREQ(range.unit, "pixels");
  EXPECT_EQ(picture.pixels[0], 0);
  EXPECT_GT(picture.pixels[7 * 3], 150);
}

/// One pixel is NaN in one channel, another one infinite, in views of every colouring.
TEST(Views, NanAndInfinityAreToldApart) {
  constexpr int kSide = 4;
  Frame frame;
  frame.width = frame.height = kSide;
  Image3 broken(kSide, kSide);
  for (int c = 0; c < 3; ++c) {
    broken[c].Fill(0.5f);
  }
  broken[1](1, 0) = NAN;
  broken[2](2, 0) = INFINITY;
  broken[0](2, 1) = NAN;
  broken[1](2, 1) = INFINITY;
  Guides& g = frame.guides;
  g.normal = g.albedo = g.specular_albedo = frame.emission = frame.background = broken;
  const Settings settings;
  Image1 plane(kSide, kSide);
  plane.Fill(0.5f);
  plane(1, 0) = plane(2, 1) = NAN;
  plane(2, 0) = INFINITY;
  g.depth = g.roughness = frame.samples = plane;
  g.motion[0] = g.motion[1] = plane;
  DenoisedFrame denoised;
  for (const char* name : {"disocclusion", "history.direct", "variance.direct"}) {
    denoised.images.push_back({name, {plane}});
  }
  const ViewSources sources = {&frame, &denoised, &broken, nullptr, &settings};
  const std::vector<ViewInfo> views = ListViews(settings);
  for (const char* name : {"noisy", "emission", "background", "samples", "depth", "normal",
                           "albedo", "specular_albedo", "motion", "roughness", "disocclusion",
                           "history.direct", "variance.direct"}) {
    ViewRange range;
    const Rgb8Image picture = ViewPicture(*FindView(views, name), sources, &range);
    const auto at = [&](int x, int y) {
      const uint8_t* p = picture.pixels.data() + 3 * (y * kSide + x);
      return Rgb8{p[0], p[1], p[2]};
    };
    const bool is_depth = std::string(name) == "depth";
    EXPECT_EQ(at(1, 0), kNanColour) << name;
    EXPECT_EQ(at(2, 0), is_depth ? Rgb8() : kInfinityColour) << name;
    EXPECT_EQ(at(2, 1), kNanColour) << name;
    EXPECT_NE(at(0, 0), kNanColour) << name;
    EXPECT_NE(at(0, 0), kInfinityColour) << name;
  }
}

TEST(Views, ValuesAtAPixelAreThoseOfThePlanes) {
  ViewSession session(
      std::move(LoadForView({"builtin:cornell", ""}, MovingSettings(), [](const LoadPhase&) {
                  return true;
                }).value()));
  ViewSettings settings = MovingSettings();
  settings.inspect = true;
  settings.inspect_x = 0.3f;
  settings.inspect_y = 0.6f;
  ViewFrame frame;
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(session
                    .RenderNext(
                        settings, 0, [](double) { return true; }, &frame)
                    .ok());
  }
  EXPECT_EQ(frame.inspect_x, 19);
  EXPECT_EQ(frame.inspect_y, 28);
  for (const InspectedValue& told : frame.inspected) {
    const std::vector<Image1> planes = session.Values(told.view).value();
    ASSERT_EQ(planes.size(), told.values.size()) << told.view;
    for (size_t c = 0; c < planes.size(); ++c) {
      EXPECT_EQ(planes[c](19, 28), told.values[c]) << told.view;
    }
  }
  EXPECT_GT(frame.inspected.size(), 20u);
}

}  // namespace
}  // namespace stillray::view::views_test
