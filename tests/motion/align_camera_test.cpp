// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "motion/align_camera.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <random>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "motion/moving_scene.h"

namespace stillray::motion::align_camera_test {
namespace {

MovingScene Scene() {
  MovingScene scene;
  scene.wall_speed = {1.3f, -0.6f};
  scene.box_speed = {5.2f, 2.4f};
  scene.box = false;
  return scene;
}

/// Guides as means of 16 samples, with noise.
GuidePyramid Noisy(const MovingScene& scene, float frame, float noise) {
  constexpr int kSide = 4;
  Guides guides = scene.At(frame);
  std::mt19937 random(static_cast<uint32_t>(frame) + 7);
  std::normal_distribution<float> numbers(0, noise);
  std::array<Guides, kSide * kSide> samples;
  for (int i = 0; i < kSide * kSide; ++i) {
    samples[static_cast<size_t>(i)] =
        scene.At(frame, vec2(i % kSide, i / kSide) / static_cast<float>(kSide) - 0.375f);
  }
  for (int c = 0; c < 3; ++c) {
    for (int y = 0; y < scene.height; ++y) {
      for (int x = 0; x < scene.width; ++x) {
        float sum = 0;
        for (const Guides& sample : samples) {
          sum += sample.albedo[c](x, y);
        }
        guides.albedo[c](x, y) = sum / (kSide * kSide) + (noise > 0 ? numbers(random) : 0.0f);
      }
    }
  }
  return MakePyramid(MakeLevel(guides));
}

/// The motion of the wall times a factor.
CameraMotion Start(const MovingScene& scene, double factor) {
  CameraMotion camera;
  camera.map = glm::dmat4x3(1.0);
  camera.depth_unit = 10;
  camera.map[2].x = -factor * static_cast<double>(scene.wall_speed.x) * 2 / scene.width;
  camera.map[2].y = -factor * static_cast<double>(scene.wall_speed.y) * 2 / scene.width;
  return camera;
}

/// The largest error in pixels over corners and middle of the picture.
double ErrorOf(const MovingScene& scene, const CameraMotion& camera) {
  double most = 0;
  for (const vec2& p : {vec2(0, 0), vec2(-0.8f, -0.5f), vec2(0.8f, 0.5f), vec2(0.8f, -0.5f)}) {
    const vec2 error = camera.MotionOf(p, 10, scene.width) + scene.wall_speed;
    most = std::max(most, static_cast<double>(glm::length(error)));
  }
  return most;
}

/// All at one depth, so that the box does not move as a nearer thing does before a moving camera.
Image1 Depth(const MovingScene& scene) {
  Image1 depth(scene.width, scene.height);
  depth.Fill(10);
  return depth;
}

CameraMotion Align(const MovingScene& scene, float noise, const CameraMotion& start) {
  const GuidePyramid now = Noisy(scene, 1, noise);
  const GuidePyramid before = Noisy(scene, 0, noise);
  return AlignCamera(now.levels[0], before.levels[0], Depth(scene), start);
}

TEST(AlignCamera, FindsTheMotionOfTheWall) {
  const MovingScene scene = Scene();
  EXPECT_GT(ErrorOf(scene, Start(scene, 0.8)), 0.25);
  EXPECT_LT(ErrorOf(scene, Align(scene, 0, Start(scene, 0.8))), 0.02);
  EXPECT_LT(ErrorOf(scene, Align(scene, 0, Start(scene, 1.2))), 0.02);
}

TEST(AlignCamera, NoiseDoesNotShortenTheMotion) {
  MovingScene scene = Scene();
  double sum = 0;
  for (uint32_t seed = 1; seed <= 6; ++seed) {
    scene.seed = 100 * seed;
    const CameraMotion aligned = Align(scene, 0.05f, Start(scene, 0.94));
    EXPECT_LT(ErrorOf(scene, aligned), 0.1);
    sum += static_cast<double>(aligned.MotionOf({0, 0}, 10, scene.width).x);
  }
  EXPECT_NEAR(sum / 6, -1.3, 0.015);
}

TEST(AlignCamera, AMovingBoxDoesNotCount) {
  MovingScene scene = Scene();
  scene.box = true;
  EXPECT_LT(ErrorOf(scene, Align(scene, 0, Start(scene, 0.9))), 0.03);
}

TEST(AlignCamera, KeepsTheStartWhereNothingIsSeenOrItIsLost) {
  MovingScene scene = Scene();
  const CameraMotion start = Start(scene, 0.9);
  scene.textured = false;
  EXPECT_EQ(Align(scene, 0, start).map, start.map);
  scene = Scene();
  const GuidePyramid now = Noisy(scene, 1, 0);
  scene.seed = 999;  // another wall
  const GuidePyramid other = Noisy(scene, 0, 0);
  const CameraMotion lost = AlignCamera(now.levels[0], other.levels[0], Depth(scene), start);
  for (const vec2& p : {vec2(0, 0), vec2(0.8f, 0.5f)}) {
    EXPECT_LT(glm::length(lost.MotionOf(p, 10, scene.width) - start.MotionOf(p, 10, scene.width)),
              1.5f);
  }
}

TEST(AlignCamera, SameBitsForAnyNumberOfThreads) {
  const MovingScene scene = Scene();
  const CameraMotion many = Align(scene, 0.05f, Start(scene, 0.94));
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const CameraMotion alone = Align(scene, 0.05f, Start(scene, 0.94));
  EXPECT_EQ(std::memcmp(&many.map, &alone.map, sizeof(many.map)), 0);
}

}  // namespace
}  // namespace stillray::motion::align_camera_test
