// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "motion/match_guides.h"

#include <cmath>

#include <gtest/gtest.h>

#include "motion/moving_scene.h"

namespace stillray::motion::match_guides_test {
namespace {

Matched Match(const Guides& now, const Guides& before, const Image2& start = {}) {
  return MatchPyramids(MakePyramid(MakeLevel(now)), MakePyramid(MakeLevel(before)), start);
}

TEST(MatchGuides, FindsASubpixelShift) {
  MovingScene scene;
  scene.box = false;
  scene.wall_speed = {3.4f, -1.7f};
  const Matched matched = Match(scene.At(1), scene.At(0));
  int good = 0;
  int all = 0;
  for (int y = 10; y < scene.height - 10; ++y) {
    for (int x = 10; x < scene.width - 10; ++x) {
      ++all;
      good += std::hypot(matched.motion[0](x, y) + 3.4f, matched.motion[1](x, y) - 1.7f) < 0.3f;
    }
  }
  EXPECT_GT(good, 0.98 * all);
}

TEST(MatchGuides, AStartThatFitsIsKept) {
  const MovingScene scene;
  const Guides guides = scene.At(0);
  const Matched matched = Match(guides, guides, Image2(scene.width, scene.height));
  for (int y = 0; y < scene.height; ++y) {
    for (int x = 0; x < scene.width; ++x) {
      ASSERT_EQ(matched.motion[0](x, y), 0);
      ASSERT_EQ(matched.motion[1](x, y), 0);
    }
  }
}

// A motion that no level's steps would find from nothing.
TEST(MatchGuides, AStartLeadsFar) {
  MovingScene scene;
  scene.box = false;
  scene.wall_speed = {70.2f, 0};
  Image2 start(scene.width, scene.height);
  start[0].Fill(-70);
  const Matched matched = Match(scene.At(1), scene.At(0), start);
  EXPECT_NEAR(matched.motion[0](150, 60), -70.2, 0.1);
  EXPECT_NEAR(matched.motion[1](150, 60), 0, 0.1);
}

TEST(MatchGuides, StructureIsThatOfTheTexture) {
  MovingScene scene;
  scene.textured = false;
  const Guides guides = scene.At(0);
  const Matched matched = Match(guides, guides);
  EXPECT_EQ(matched.structure(10, 10), 0);
  EXPECT_GT(matched.structure(86, 60), 0.01f);
}

TEST(MatchGuides, TinyPicturesAndInvalidGuidesDoNoHarm) {
  for (const int size : {1, 2, 7, 41}) {
    Guides guides;
    guides.depth = Image1(size, size);
    guides.normal = Image3(size, size);
    guides.depth.Fill(NAN);
    guides.normal[0].Fill(INFINITY);
    const Matched matched = Match(guides, guides);
    EXPECT_EQ(matched.motion.width(), size);
    EXPECT_EQ(matched.motion[0](0, 0), 0);
  }
}

TEST(Agreement, IsThatOfThereAndBack) {
  Image2 forth(8, 8);
  Image2 back(8, 8);
  forth[0].Fill(2);
  back[0].Fill(-2);
  EXPECT_EQ(AgreementOf(forth, back)(3, 3), 1);
  EXPECT_EQ(AgreementOf(forth, back)(7, 3), 0) << "leads out of the picture";
  back[0].Fill(-3);  // off by one pixel: half of the way from 0.5 to 1.5, plus a twentieth of 2
  EXPECT_NEAR(AgreementOf(forth, back)(3, 3), 0.6, 1e-5);
  back[0].Fill(2);
  EXPECT_EQ(AgreementOf(forth, back)(3, 3), 0);
}

// Four pixels around (2.5, 2) have distances 0.3, 0.1, ... from the pixel: the least counts.
TEST(Distance, IsToTheMostSimilarOfFourPixels) {
  Guides now;
  now.depth = Image1(6, 6);
  now.depth.Fill(1);
  now.normal = Image3(6, 6);
  now.albedo = Image3(6, 6);
  Guides before = now;
  for (int c = 0; c < 3; ++c) {
    before.albedo[c].Fill(1);
  }
  before.albedo[0](3, 2) = 0.05f;  // times 2
  before.albedo[1](3, 2) = 0;
  before.albedo[2](3, 2) = 0;
  const GuideLevel a = MakeLevel(now);
  const GuideLevel b = MakeLevel(before);
  EXPECT_NEAR(DistanceTo(a, 0, 0, b, 2.5f, 2), 0.1, 1e-6);
  EXPECT_EQ(DistanceTo(a, 0, 0, b, 4.5f, 2), kMostDistance);
  EXPECT_EQ(DistanceTo(a, 0, 0, b, 2, 2), kMostDistance) << "between no two pixels";
  EXPECT_EQ(DistanceTo(a, 0, 0, b, -0.1f, 2), kMostDistance);
  EXPECT_EQ(DistanceTo(a, 0, 0, b, NAN, 2), kMostDistance);
}

}  // namespace
}  // namespace stillray::motion::match_guides_test
