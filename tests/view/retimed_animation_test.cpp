// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "view/retimed_animation.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace stillray::view::retimed_animation_test {
namespace {

/// Nodes: 0 a lamp that moves along x, 1 a box that turns about y, 2 a camera that moves along z.
Scene MovingScene() {
  Scene scene;
  scene.nodes.resize(3);
  scene.materials.resize(1);
  scene.meshes.resize(1);
  scene.meshes[0].material = 0;
  scene.instances.push_back({0, 1});
  PunctualLight light;
  light.node = 0;
  scene.lights.push_back(light);
  Camera camera;
  camera.node = 2;
  scene.cameras.push_back(camera);
  const float half = std::sqrt(0.5f);
  scene.animation.push_back({0,
                             AnimatedProperty::kTranslation,
                             Interpolation::kLinear,
                             {0, 4},
                             {vec4(0), vec4(4, 0, 0, 0)}});
  scene.animation.push_back({1,
                             AnimatedProperty::kRotation,
                             Interpolation::kLinear,
                             {0, 4},
                             {vec4(0, 0, 0, 1), vec4(0, half, 0, half)}});
  scene.animation.push_back({2,
                             AnimatedProperty::kTranslation,
                             Interpolation::kLinear,
                             {0, 4},
                             {vec4(0), vec4(0, 0, 4, 0)}});
  return scene;
}

void ExpectNear(const mat4& a, const mat4& b) {
  for (int c = 0; c < 4; ++c) {
    for (int r = 0; r < 4; ++r) {
      EXPECT_NEAR(a[c][r], b[c][r], 1e-5) << c << " " << r;
    }
  }
}

TEST(RetimedAnimation, WithOneClockTheSceneIsAsItWas) {
  Scene scene = MovingScene();
  RetimedAnimation animation(&scene);
  EXPECT_TRUE(animation.has_lights());
  double now = 0;
  double before = 0;
  animation.Set({3, 3}, {2.5, 2.5}, &now, &before);
  EXPECT_EQ(now, 3);
  EXPECT_EQ(before, 2.5);
  EXPECT_EQ(scene.animation[0].times.size(), 2u);
  EXPECT_EQ(scene.animation[0].interpolation, Interpolation::kLinear);
}

TEST(RetimedAnimation, MorphWeightsAndEmissiveSkinsFollowTheirClock) {
  Scene scene = MovingScene();
  scene.nodes[1].weights = {0, 0};
  AnimationChannel weights;
  weights.node = 1;
  weights.property = AnimatedProperty::kWeights;
  weights.times = {0, 4};
  weights.weights = {0, 1, 4, 5};
  scene.animation.push_back(weights);
  // Node 3 is the joint of a mesh that emits, on node 0.
  scene.nodes.emplace_back();
  AnimationChannel joint = scene.animation[0];
  joint.node = 3;
  scene.animation.push_back(joint);
  scene.skins.push_back({"", {3}, {mat4(1.0f)}});
  scene.materials.emplace_back();
  scene.materials[1].emission = vec3(1);
  scene.meshes.emplace_back();
  scene.meshes[1].material = 1;
  scene.instances.push_back({1, 0, 0});
  const Scene original = scene;
  RetimedAnimation animation(&scene);
  double now = 0;
  double before = 0;
  animation.Set({1, 3}, {0.5, 3.5}, &now, &before);
  EXPECT_EQ(MorphWeights(scene, 1, now), MorphWeights(original, 1, 1));
  EXPECT_EQ(MorphWeights(scene, 1, before), MorphWeights(original, 1, 0.5));
  ExpectNear(NodeTransforms(scene, now)[3], NodeTransforms(original, 3)[3]);
  ExpectNear(NodeTransforms(scene, before)[3], NodeTransforms(original, 3.5)[3]);
}

TEST(RetimedAnimation, LightsHaveAClockOfTheirOwn) {
  Scene scene = MovingScene();
  const Scene original = scene;
  RetimedAnimation animation(&scene);
  double now = 0;
  double before = 0;
  animation.Set({1, 3}, {0.5, 3.5}, &now, &before);
  const std::vector<mat4> is = NodeTransforms(scene, now);
  const std::vector<mat4> was = NodeTransforms(scene, before);
  ExpectNear(is[0], NodeTransforms(original, 3)[0]);
  ExpectNear(was[0], NodeTransforms(original, 3.5)[0]);
  for (const size_t node : {1u, 2u}) {
    ExpectNear(is[node], NodeTransforms(original, 1)[node]);
    ExpectNear(was[node], NodeTransforms(original, 0.5)[node]);
  }
  // Both clocks agree again: so does the scene.
  animation.Set({2, 2}, {2, 2}, &now, &before);
  EXPECT_EQ(now, 2);
  ExpectNear(NodeTransforms(scene, 2)[1], NodeTransforms(original, 2)[1]);
}

TEST(RetimedAnimation, ALightAboveACameraBelongsToTheRest) {
  Scene scene = MovingScene();
  scene.lights[0].node = 2;  // a lamp on the camera
  const RetimedAnimation animation(&scene);
  EXPECT_FALSE(animation.has_lights());
}

TEST(RetimedAnimation, GlowingMeshesAreLights) {
  Scene scene = MovingScene();
  scene.lights.clear();
  scene.materials[0].emission = vec3(1);
  RetimedAnimation animation(&scene);
  EXPECT_TRUE(animation.has_lights());
  double now = 0;
  double before = 0;
  animation.Set({0, 4}, {0, 4}, &now, &before);
  const Scene original = MovingScene();
  ExpectNear(NodeTransforms(scene, now)[1], NodeTransforms(original, 4)[1]);
  ExpectNear(NodeTransforms(scene, now)[0], NodeTransforms(original, 0)[0]);
}

}  // namespace
}  // namespace stillray::view::retimed_animation_test
