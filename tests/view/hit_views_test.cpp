// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "view/hit_views.h"

#include <cmath>
#include <utility>

#include <gtest/gtest.h>

#include "render/test_scenes.h"
#include "view/small_session.h"

namespace stillray::view::hit_views_test {
namespace {

/// A pixel at distance 2 is 1 wide: of 4 x 4 pixels the inner ones lie at -0.5 and 0.5.
RenderMoment FromTheOrigin() {
  RenderMoment moment;
  moment.pose = CameraPose{mat4(1.0f), 2 * std::atan(1.0f)};
  return moment;
}

Frame FrameOfSize(int width, int height) {
  Frame frame;
  frame.width = width;
  frame.height = height;
  return frame;
}

Material WithAlpha(AlphaMode mode, float alpha) {
  Material material = render::Lambert(vec3(1.0f));
  material.base_color.w = alpha;
  material.alpha_mode = mode;
  return material;
}

/// A wall of 2 x 2 at distance 2, behind a cut-out and a pane of 0.4.
Scene WallBehindPanes() {
  render::SceneBuilder builder;
  builder.Add(render::Quad(vec3(-2, -2, -1), vec3(4, 0, 0), vec3(0, 4, 0)),
              WithAlpha(AlphaMode::kMask, 0));
  builder.Add(render::Quad(vec3(-2, -2, -1.5f), vec3(4, 0, 0), vec3(0, 4, 0)),
              WithAlpha(AlphaMode::kBlend, 0.4f));
  builder.Add(render::Quad(vec3(-1, -1, -2), vec3(2, 0, 0), vec3(0, 2, 0)),
              render::Lambert(vec3(0.5f)));
  return std::move(builder.scene);
}

void ExpectHit(const HitViews& views, int x, int y, uint32_t triangle, vec3 weights) {
  EXPECT_EQ(views.triangle(x, y), triangle) << x << ", " << y;
  EXPECT_EQ(views.material(x, y), 3u) << x << ", " << y;
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(views.barycentrics[c](x, y), weights[c], 1e-4) << x << ", " << y << ", " << c;
  }
}

// By hand: the wall's first triangle lies below its diagonal, the other one above.
TEST(HitViews, TheFirstMostlyOpaqueSurfaceCounts) {
  const Scene scene = WallBehindPanes();
  auto finder = HitFinder::Create(scene);
  ASSERT_TRUE(finder.ok()) << finder.status().message();
  Frame frame = FrameOfSize(4, 4);
  const HitViews views = (*finder)->Find(FromTheOrigin(), frame).value();
  ExpectHit(views, 1, 1, 2, vec3(0.25f, 0.25f, 0.5f));
  ExpectHit(views, 2, 2, 1, vec3(0.25f, 0.5f, 0.25f));
  EXPECT_EQ(views.triangle(0, 1), 0u);
  EXPECT_EQ(views.material(0, 1), 0u);
  EXPECT_EQ(views.barycentrics[0](0, 1), 0);
  frame.jitter_x = 0.25f;  // an eighth of the wall to the right
  ExpectHit((*finder)->Find(FromTheOrigin(), frame).value(), 2, 2, 1, vec3(0.125f, 0.625f, 0.25f));
}

// Rows are divided where they are longer than a batch of rays.
TEST(HitViews, PicturesMayBeWiderThanABatch) {
  const Scene scene = WallBehindPanes();
  auto finder = HitFinder::Create(scene);
  ASSERT_TRUE(finder.ok()) << finder.status().message();
  const int width = render::kBatchCapacity * 2 + 32;
  const HitViews views = (*finder)->Find(FromTheOrigin(), FrameOfSize(width, width / 4)).value();
  const int y = width / 8 + 3;
  for (int x = 0; x < width; ++x) {
    // The picture is four times as wide as high; the wall covers the middle half of its height.
    const double at = ((x + 0.5) / width * 2 - 1) * 4 * 2;
    if (std::fabs(std::fabs(at) - 1) > 0.01) {
      ASSERT_EQ(views.material(x, y), std::fabs(at) < 1 ? 3u : 0u) << x;
    }
  }
}

// Weights and materials go together with the guides of the frame, while everything moves.
TEST(HitViews, BelongToTheFrameThatIsShown) {
  ViewSettings settings = SmallSettings();
  settings.playing = true;
  settings.panes = {"barycentrics", "triangle", "material"};
  ViewSession session = Open("builtin:lights");
  for (int i = 0; i < 3; ++i) {
    Next(settings, &session);
  }
  const std::vector<Image1> weights = session.Values("barycentrics").value();
  const std::vector<Image1> triangle = session.Values("triangle").value();
  const std::vector<Image1> material = session.Values("material").value();
  const std::vector<Image1> id = session.Values("id").value();
  ASSERT_EQ(weights.size(), 3u);
  int surfaces = 0;
  for (int y = 0; y < id[0].height(); ++y) {
    for (int x = 0; x < id[0].width(); ++x) {
      const bool seen = id[0](x, y) > 0;
      surfaces += seen ? 1 : 0;
      ASSERT_EQ(triangle[0](x, y) > 0, seen) << x << ", " << y;
      ASSERT_EQ(material[0](x, y) > 0, seen) << x << ", " << y;
      ASSERT_NEAR(weights[0](x, y) + weights[1](x, y) + weights[2](x, y), seen ? 1 : 0, 1e-5);
    }
  }
  EXPECT_GT(surfaces, 100);
  settings.panes = {"denoised"};
  Next(settings, &session);
  EXPECT_FALSE(session.Values("triangle").ok()) << "found only while they are shown";
}

}  // namespace
}  // namespace stillray::view::hit_views_test
