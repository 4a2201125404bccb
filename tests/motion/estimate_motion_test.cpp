// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "motion/estimate_motion.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "core/guides.h"
#include "motion/moving_scene.h"

namespace stillray::motion::estimate_motion_test {
namespace {

enum class Where { kAll, kBox, kWall };

EstimatedMotion EstimateOf(const MovingScene& scene, bool camera_known) {
  const Guides now = scene.At(1);
  const Guides before = scene.At(0);
  EstimateInput input;
  input.now = &now;
  input.before = &before;
  if (camera_known) {
    input.camera = Image2(scene.width, scene.height);
    input.camera[0].Fill(-scene.wall_speed.x);
    input.camera[1].Fill(-scene.wall_speed.y);
  }
  return EstimateMotion(input);
}

/// Part of the pixels that were in view whose motion is wrong by less than `limit` pixels.
double PartWithin(const MovingScene& scene, const Image2& motion, Where where, float limit) {
  int all = 0;
  int good = 0;
  for (int y = 0; y < scene.height; ++y) {
    for (int x = 0; x < scene.width; ++x) {
      const bool box = scene.ShowsBox(x, y, 1);
      if (!scene.WasSeen(x, y, 1) || (where == Where::kBox && !box) ||
          (where == Where::kWall && box)) {
        continue;
      }
      const vec2 error = vec2(motion[0](x, y), motion[1](x, y)) - scene.TrueMotion(x, y, 1);
      ++all;
      good += glm::length(error) < limit;
    }
  }
  return static_cast<double>(good) / all;
}

MovingScene SceneWithMovingBox() {
  MovingScene scene;
  scene.wall_speed = {1.3f, -0.6f};
  scene.box_speed = {5.2f, 2.4f};
  return scene;
}

TEST(EstimateMotion, AMovingBoxBeforeAKnownCamera) {
  const MovingScene scene = SceneWithMovingBox();
  const EstimatedMotion estimated = EstimateOf(scene, true);
  EXPECT_GT(PartWithin(scene, estimated.motion, Where::kBox, 0.3f), 0.95);
  EXPECT_GT(PartWithin(scene, estimated.motion, Where::kWall, 1e-4f), 0.99);
  EXPECT_GT(estimated.of_objects, 0.05);
  EXPECT_FALSE(estimated.found_camera);
}

TEST(EstimateMotion, AMovingBoxBeforeAnUnknownCamera) {
  const MovingScene scene = SceneWithMovingBox();
  const EstimatedMotion estimated = EstimateOf(scene, false);
  EXPECT_TRUE(estimated.found_camera);
  EXPECT_GT(PartWithin(scene, estimated.motion, Where::kBox, 0.3f), 0.95);
  EXPECT_GT(PartWithin(scene, estimated.motion, Where::kWall, 0.3f), 0.98);
}

TEST(EstimateMotion, ATurningBox) {
  MovingScene scene = SceneWithMovingBox();
  scene.box_turn = 0.05f;
  EXPECT_GT(PartWithin(scene, EstimateOf(scene, true).motion, Where::kBox, 0.3f), 0.95);
}

TEST(EstimateMotion, WithoutIds) {
  MovingScene scene = SceneWithMovingBox();
  scene.ids = false;
  const EstimatedMotion estimated = EstimateOf(scene, true);
  EXPECT_GT(PartWithin(scene, estimated.motion, Where::kBox, 0.3f), 0.9);
  EXPECT_GT(PartWithin(scene, estimated.motion, Where::kWall, 0.3f), 0.98);
  EXPECT_GT(estimated.matched, 0.05);
}

// All of a picture moves by exactly one pixel, to each side.
TEST(EstimateMotion, OnePixelIsNotStill) {
  for (const vec2& speed : {vec2(1, 0), vec2(-1, 0), vec2(0, 1), vec2(0, -1)}) {
    MovingScene scene;
    scene.wall_speed = scene.box_speed = speed;
    EXPECT_GT(PartWithin(scene, EstimateOf(scene, false).motion, Where::kAll, 0.3f), 0.95)
        << speed.x << " " << speed.y;
  }
}

TEST(EstimateMotion, OfAStillPictureIsZero) {
  const EstimatedMotion estimated = EstimateOf(MovingScene(), false);
  EXPECT_EQ(estimated.unknown, 0);
  EXPECT_EQ(estimated.estimated(), 0);
  for (int c = 0; c < 2; ++c) {
    for (int y = 0; y < estimated.motion.height(); ++y) {
      const float* row = estimated.motion[c].Row(y);
      EXPECT_TRUE(std::all_of(row, row + estimated.motion.width(), [](float v) { return v == 0; }));
    }
  }
  EXPECT_EQ(estimated.confidence(3, 3), 1);
}

TEST(EstimateMotion, IsUnknownIfGuidesArePlain) {
  MovingScene scene;
  scene.box = false;
  scene.textured = false;
  const EstimatedMotion estimated = EstimateOf(scene, false);
  EXPECT_EQ(estimated.unknown, 1);
  const vec2 unknown = UnknownMotion(scene.width, scene.height);
  EXPECT_EQ(estimated.motion[0](5, 5), unknown.x);
  EXPECT_EQ(estimated.confidence(5, 5), 0);
  EXPECT_EQ(EstimateOf(scene, true).unknown, 0) << "a camera needs no guides";
}

TEST(EstimateMotion, AcrossACutIsUnknown) {
  MovingScene scene;
  MovingScene other;
  other.seed = 77;
  other.box = false;
  const Guides now = scene.At(0);
  const Guides before = other.At(0);
  EstimateInput input;
  input.now = &now;
  input.before = &before;
  EXPECT_GT(EstimateMotion(input).unknown, 0.9);
}

/// Makes the colours of the box random, as those of hair are.
void MakeBoxRandom(const MovingScene& scene, float frame, uint32_t seed, Guides* guides) {
  for (int y = 0; y < scene.height; ++y) {
    for (int x = 0; x < scene.width; ++x) {
      for (uint32_t c = 0; scene.ShowsBox(x, y, frame) && c < 3; ++c) {
        const auto at = static_cast<uint32_t>(y * scene.width + x) * 3 + c;
        uint32_t h = (at ^ seed) * 2654435761u;
        h = (h ^ (h >> 15)) * 2246822519u;
        guides->albedo[static_cast<int>(c)](x, y) = static_cast<float>(h >> 16) / 65536;
      }
    }
  }
}

TEST(EstimateMotion, WhatNothingExplainsKeepsTheLikeliestMotion) {
  const MovingScene scene = SceneWithMovingBox();
  Guides now = scene.At(1);
  Guides before = scene.At(0);
  MakeBoxRandom(scene, 1, 0x51ed2701u, &now);
  MakeBoxRandom(scene, 0, 0x9e3779b9u, &before);
  EstimateInput input;
  input.now = &now;
  input.before = &before;
  const EstimatedMotion estimated = EstimateMotion(input);
  ASSERT_TRUE(estimated.found_camera);
  int pixels = 0;
  int uncertain = 0;
  for (int y = 0; y < scene.height; ++y) {
    for (int x = 0; x < scene.width; ++x) {
      if (scene.ShowsBox(x, y, 1)) {
        ++pixels;
        uncertain += estimated.confidence(x, y) == 0;
        EXPECT_LT(std::hypot(estimated.motion[0](x, y), estimated.motion[1](x, y)), 60.0f)
            << x << " " << y;
      }
    }
  }
  EXPECT_GT(uncertain, 0.8 * pixels);
  EXPECT_NEAR(estimated.unknown, static_cast<double>(uncertain) / (scene.width * scene.height),
              0.03);
  EXPECT_GT(PartWithin(scene, estimated.motion, Where::kWall, 0.3f), 0.98);
}

// What the box uncovers was not in view: it has no motion that a history would be found by, or the
// wall's, which leads to the box.
TEST(EstimateMotion, UncoveredPixelsAreNotMatched) {
  const MovingScene scene = SceneWithMovingBox();
  const EstimatedMotion estimated = EstimateOf(scene, true);
  int uncovered = 0;
  int wrong = 0;
  for (int y = 5; y < scene.height - 5; ++y) {
    for (int x = 5; x < scene.width - 5; ++x) {
      if (scene.ShowsBox(x, y, 1) || scene.WasSeen(x, y, 1)) {
        continue;
      }
      ++uncovered;
      const vec2 motion(estimated.motion[0](x, y), estimated.motion[1](x, y));
      wrong += motion != UnknownMotion(scene.width, scene.height) &&
               glm::length(motion + scene.wall_speed) > 0.5f;
    }
  }
  EXPECT_GT(uncovered, 100);
  EXPECT_LT(wrong, uncovered / 10);
}

// Sample positions move by (0.7, -0.4) pixels between the frames; nothing else does.
TEST(EstimateMotion, ExcludesJitter) {
  const MovingScene scene;
  const vec2 jitter(0.4f, -0.3f);
  const vec2 jitter_before(-0.3f, 0.1f);
  const Guides now = scene.At(0, jitter);
  const Guides before = scene.At(0, jitter_before);
  EstimateInput input;
  input.now = &now;
  input.before = &before;
  input.jitter = jitter;
  input.jitter_before = jitter_before;
  const Image2 motion = EstimateMotion(input).motion;
  std::vector<float> errors;
  for (int y = 8; y < scene.height - 8; ++y) {
    for (int x = 8; x < scene.width - 8; ++x) {
      errors.push_back(std::hypot(motion[0](x, y), motion[1](x, y)));
    }
  }
  std::sort(errors.begin(), errors.end());
  EXPECT_LT(errors[errors.size() * 95 / 100], 0.3f);
}

TEST(EstimateMotion, SameBitsForAnyNumberOfThreads) {
  MovingScene scene = SceneWithMovingBox();
  scene.box_turn = 0.02f;
  for (const bool camera_known : {true, false}) {
    std::vector<EstimatedMotion> results;
    for (const size_t threads : {1, 3}) {
      const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
      results.push_back(EstimateOf(scene, camera_known));
    }
    for (int y = 0; y < scene.height; ++y) {
      const size_t bytes = static_cast<size_t>(scene.width) * sizeof(float);
      for (int c = 0; c < 2; ++c) {
        EXPECT_EQ(std::memcmp(results[0].motion[c].Row(y), results[1].motion[c].Row(y), bytes), 0);
      }
      EXPECT_EQ(std::memcmp(results[0].confidence.Row(y), results[1].confidence.Row(y), bytes), 0);
    }
  }
}

TEST(EstimateMotion, TinyPicturesAndInvalidGuidesDoNoHarm) {
  for (const int size : {1, 3, 19, 45}) {
    MovingScene scene;
    scene.width = scene.height = size;
    Guides now = scene.At(1);
    Guides before = scene.At(0);
    now.depth(0, 0) = std::numeric_limits<float>::quiet_NaN();
    now.albedo[0](size - 1, size - 1) = std::numeric_limits<float>::infinity();
    before.depth(0, 0) = -1;
    before.normal[1](size / 2, 0) = std::numeric_limits<float>::quiet_NaN();
    EstimateInput input;
    input.now = &now;
    input.before = &before;
    const EstimatedMotion estimated = EstimateMotion(input);
    EXPECT_EQ(estimated.motion.width(), size);
    EXPECT_TRUE(std::isfinite(estimated.motion[0](0, 0)));
  }
}

}  // namespace
}  // namespace stillray::motion::estimate_motion_test
