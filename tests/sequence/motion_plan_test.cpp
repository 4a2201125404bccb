// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// What frames get with motion that their files lack.
#include "sequence/motion_plan.h"

#include <cmath>
#include <optional>

#include <gtest/gtest.h>

#include "core/guides.h"
#include "motion/moving_scene.h"
#include "sequence/motion_cache.h"

namespace stillray::motion_plan_test {
namespace {

const std::optional<CameraMatrices> kNoCamera;

MovingScene MovingWall(vec2 speed) {
  MovingScene scene;
  scene.wall_speed = speed;
  scene.box_speed = speed + vec2(3, 1);
  return scene;
}

Frame FrameAt(const MovingScene& scene, int index) {
  Frame frame;
  frame.width = scene.width;
  frame.height = scene.height;
  frame.index = index;
  frame.guides = scene.At(static_cast<float>(index));
  frame.guides.motion = Image2(scene.width, scene.height);
  return frame;
}

/// A square at the left of the wall, of which nothing was there before.
constexpr int kPatch = 10;
constexpr int kPatchSize = 24;
void Repaint(Frame* frame) {
  for (int y = kPatch; y < kPatch + kPatchSize; ++y) {
    for (int x = kPatch; x < kPatch + kPatchSize; ++x) {
      frame->guides.id(x, y) = 99;
      const float colour = ((x * 7 + y * 13) % 5 < 2) ? 0.95f : 0.05f;
      for (int c = 0; c < 3; ++c) {
        frame->guides.albedo[c](x, y) = c == (x + y) % 3 ? colour : 1 - colour;
      }
    }
  }
}

Image1 Constant(const MovingScene& scene, float value) {
  Image1 image(scene.width, scene.height);
  image.Fill(value);
  return image;
}

/// Zeros in the file, as Blender writes them with motion blur.
MotionOrigin Complete(const MovingScene& scene, const Image1& loss, Frame* now) {
  MotionPlan plan;
  plan.from_file = plan.estimates = true;
  const Frame before = FrameAt(scene, 0);
  return CompleteMotion({before, kNoCamera}, plan, AovLayout(), {now, kNoCamera, loss});
}

constexpr int kMiddle = kPatch + kPatchSize / 2;  // of the patch
constexpr int kFarX = 20;                         // on the wall
constexpr int kFarY = 90;

TEST(CompleteMotion, UncertainMotionHalvesTheHistory) {
  const MovingScene scene = MovingWall({1.3f, -0.6f});
  Frame now = FrameAt(scene, 1);
  Repaint(&now);
  const MotionOrigin origin = Complete(scene, Image1(), &now);
  ASSERT_EQ(origin.kind, MotionKind::kEstimate);
  EXPECT_GT(origin.unknown, 0.01);
  EXPECT_EQ(now.confidence(kMiddle, kMiddle), 0.5f);
  EXPECT_LT(std::fabs(now.guides.motion[0](kMiddle, kMiddle)), 60.0f);
  EXPECT_EQ(now.confidence(kFarX, kFarY), 1.0f);
  EXPECT_NEAR(now.guides.motion[0](kFarX, kFarY), -1.3f, 0.2f);
}

TEST(CompleteMotion, TheSmallerConfidenceCounts) {
  const MovingScene scene = MovingWall({1.3f, -0.6f});
  Frame now = FrameAt(scene, 1);
  Repaint(&now);
  now.confidence = Constant(scene, 0.75f);
  now.confidence(kMiddle, kMiddle) = 0.25f;
  Complete(scene, Image1(), &now);
  EXPECT_EQ(now.confidence(kMiddle, kMiddle), 0.25f);
  EXPECT_EQ(now.confidence(kMiddle + 1, kMiddle), 0.5f);
  EXPECT_EQ(now.confidence(kFarX, kFarY), 0.75f);
}

// At import motion was zero, under which nothing is lost.
TEST(CompleteMotion, LossesAreThoseOfTheMotionThatWasFound) {
  for (const bool moves : {false, true}) {
    const MovingScene scene = MovingWall(moves ? vec2(1.3f, -0.6f) : vec2(0.0f));
    Frame now = FrameAt(scene, 1);
    now.confidence = Constant(scene, 1);
    ASSERT_EQ(Complete(scene, Constant(scene, 0.6f), &now).kind, MotionKind::kEstimate);
    // The camera is found to a hundredth of a pixel.
    EXPECT_NEAR(now.confidence(kFarX, kFarY), moves ? 0.4f : 1.0f, 0.03f);
  }
}

TEST(CompleteMotion, MotionOfTheFileKeepsTheConfidenceOfTheImport) {
  const MovingScene scene = MovingWall({1.3f, -0.6f});
  Frame now = FrameAt(scene, 1);
  now.guides.motion[0].Fill(-1.3f);
  now.confidence = Constant(scene, 0.9f);
  EXPECT_EQ(Complete(scene, Constant(scene, 0.6f), &now).kind, MotionKind::kFile);
  EXPECT_EQ(now.confidence(kFarX, kFarY), 0.9f);
}

TEST(MotionCaches, HoldMotionAndConfidence) {
  const MovingScene scene = MovingWall({1.3f, -0.6f});
  Frame now = FrameAt(scene, 1);
  Repaint(&now);
  const MotionOrigin origin = Complete(scene, Constant(scene, 0.3f), &now);
  MotionCache cache(1);
  cache.Keep(now, origin);
  Frame again = FrameAt(scene, 1);
  again.confidence = Constant(scene, 1);
  MotionOrigin restored;
  ASSERT_TRUE(cache.Restore(&again, &restored));
  EXPECT_EQ(restored.unknown, origin.unknown);
  for (int y = 0; y < scene.height; ++y) {
    for (int x = 0; x < scene.width; ++x) {
      EXPECT_EQ(again.confidence(x, y), now.confidence(x, y));
      EXPECT_EQ(again.guides.motion[0](x, y), now.guides.motion[0](x, y));
    }
  }
  cache.Keep(FrameAt(scene, 2), origin);  // drops the older one
  EXPECT_FALSE(cache.Restore(&again, &restored));
}

}  // namespace
}  // namespace stillray::motion_plan_test
