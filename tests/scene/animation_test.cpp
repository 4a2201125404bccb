// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "stillray/scene.h"

namespace stillray::animation_test {
namespace {

constexpr float kSqrtHalf = 0.70710678f;

Scene OneNode(AnimationChannel channel) {
  Scene scene;
  scene.nodes.emplace_back();
  channel.node = 0;
  scene.animation.push_back(std::move(channel));
  return scene;
}

vec3 TranslationAt(const Scene& scene, double seconds) {
  return vec3(NodeTransforms(scene, seconds)[0][3]);
}

AnimationChannel TwoKeys(Interpolation interpolation) {
  AnimationChannel channel;
  channel.interpolation = interpolation;
  channel.times = {1.0f, 3.0f};
  channel.values = {vec4(2, 0, 0, 0), vec4(6, 4, -8, 0)};
  return channel;
}

void ExpectNear(vec3 a, vec3 b, float tolerance) {
  EXPECT_NEAR(a.x, b.x, tolerance);
  EXPECT_NEAR(a.y, b.y, tolerance);
  EXPECT_NEAR(a.z, b.z, tolerance);
}

TEST(Transform, MatrixOfHandWorkedExample) {
  // A quarter turn about +z takes x to y and y to -x; scaled first, moved last.
  Transform transform;
  transform.translation = vec3(10, 20, 30);
  transform.rotation = vec4(0, 0, kSqrtHalf, kSqrtHalf);
  transform.scale = vec3(2, 3, 4);
  const mat4 m = transform.ToMatrix();
  ExpectNear(vec3(m * vec4(1, 0, 0, 1)), vec3(10, 22, 30), 1e-5f);
  ExpectNear(vec3(m * vec4(0, 1, 0, 1)), vec3(7, 20, 30), 1e-5f);
  ExpectNear(vec3(m * vec4(0, 0, 1, 1)), vec3(10, 20, 34), 1e-5f);
}

TEST(Animation, LinearInterpolatesAndHoldsBeyondItsEnds) {
  const Scene scene = OneNode(TwoKeys(Interpolation::kLinear));
  EXPECT_EQ(TranslationAt(scene, -5.0), vec3(2, 0, 0));
  EXPECT_EQ(TranslationAt(scene, 1.0), vec3(2, 0, 0));
  EXPECT_EQ(TranslationAt(scene, 1.5), vec3(3, 1, -2));
  EXPECT_EQ(TranslationAt(scene, 3.0), vec3(6, 4, -8));
  EXPECT_EQ(TranslationAt(scene, 1e9), vec3(6, 4, -8));
}

TEST(Animation, StepKeepsTheLastKey) {
  const Scene scene = OneNode(TwoKeys(Interpolation::kStep));
  EXPECT_EQ(TranslationAt(scene, 2.999), vec3(2, 0, 0));
  EXPECT_EQ(TranslationAt(scene, 3.0), vec3(6, 4, -8));
}

TEST(Animation, CubicSplineOfHandWorkedExample) {
  // Keys at 0 and 2 s, values 1 and 5, out-tangent 3 and in-tangent -1 per second. At t = 1/2:
  // h00 = 1/2, h10 = 1/8, h01 = 1/2, h11 = -1/8, tangents times the gap of 2:
  // 1/2 * 1 + 1/8 * 6 + 1/2 * 5 - 1/8 * -2 = 4.
  AnimationChannel channel;
  channel.interpolation = Interpolation::kCubicSpline;
  channel.times = {0.0f, 2.0f};
  channel.values = {vec4(99),          vec4(1, 0, 0, 0), vec4(3, 0, 0, 0),
                    vec4(-1, 0, 0, 0), vec4(5, 0, 0, 0), vec4(99)};
  const Scene scene = OneNode(channel);
  EXPECT_FLOAT_EQ(TranslationAt(scene, 1.0).x, 4.0f);
  EXPECT_FLOAT_EQ(TranslationAt(scene, 0.0).x, 1.0f);
  EXPECT_FLOAT_EQ(TranslationAt(scene, 2.0).x, 5.0f);
  // At t = 1/4: h00 = 27/32, h10 = 9/64, h01 = 5/32, h11 = -3/64.
  EXPECT_NEAR(TranslationAt(scene, 0.5).x, 27.0 / 32 + 6 * 9.0 / 64 + 5 * 5.0 / 32 + 2 * 3.0 / 64,
              1e-5);
}

TEST(Animation, RotationTakesTheShorterArcAtConstantSpeed) {
  AnimationChannel channel;
  channel.property = AnimatedProperty::kRotation;
  channel.times = {0.0f, 1.0f};
  // No rotation, and 90 degrees about y written as its negative: the same rotation, the other way
  // round on the sphere of quaternions.
  channel.values = {vec4(0, 0, 0, 1), vec4(0, -kSqrtHalf, 0, -kSqrtHalf)};
  const Scene scene = OneNode(channel);
  for (const double t : {0.0, 0.25, 0.5, 0.75, 1.0}) {
    const vec3 x(NodeTransforms(scene, t)[0][0]);
    const double angle = t * 0.5 * 3.14159265358979;
    ExpectNear(x, vec3(std::cos(angle), 0, -std::sin(angle)), 2e-6f);
  }
}

TEST(Animation, RotationOfNearlyEqualKeysStaysUnit) {
  AnimationChannel channel;
  channel.property = AnimatedProperty::kRotation;
  channel.times = {0.0f, 1.0f};
  channel.values = {vec4(0, 0, 0, 1), vec4(0, 1e-4f, 0, 1)};
  const mat4 m = NodeTransforms(OneNode(channel), 0.5)[0];
  EXPECT_NEAR(glm::length(vec3(m[0])), 1.0f, 1e-6f);
  EXPECT_NEAR(m[0].z, -1e-4f, 1e-7f);
}

TEST(Animation, RotationThroughZeroIsNoRotation) {
  AnimationChannel channel;
  channel.property = AnimatedProperty::kRotation;
  channel.interpolation = Interpolation::kStep;
  channel.times = {0.0f};
  channel.values = {vec4(0.0f)};
  EXPECT_EQ(NodeTransforms(OneNode(channel), 0.0)[0], mat4(1.0f));
}

TEST(Animation, MovesChildrenWithTheirParents) {
  Scene scene = OneNode(TwoKeys(Interpolation::kLinear));
  Node child;
  child.parent = 0;
  child.local.translation = vec3(0, 1, 0);
  scene.nodes.push_back(child);
  EXPECT_EQ(vec3(NodeTransforms(scene, 2.0)[1][3]), vec3(4, 3, -4));
}

TEST(Animation, LengthIsTheLastKey) {
  EXPECT_DOUBLE_EQ(OneNode(TwoKeys(Interpolation::kLinear)).AnimationLength(), 3.0);
  EXPECT_DOUBLE_EQ(Scene().AnimationLength(), 0.0);
}

TEST(SceneBounds, FollowsTheAnimation) {
  Scene scene = OneNode(TwoKeys(Interpolation::kLinear));
  Mesh mesh;
  mesh.positions = {vec3(-1, 0, 0), vec3(1, 0, 0), vec3(0, 2, 0.5f)};
  mesh.indices = {0, 1, 2};
  scene.meshes.push_back(mesh);
  scene.instances.push_back({0, 0});
  const Aabb bounds = SceneBounds(scene, 1.5);
  EXPECT_EQ(bounds.min, vec3(2, 1, -2));
  EXPECT_EQ(bounds.max, vec3(4, 3, -1.5f));
}

}  // namespace
}  // namespace stillray::animation_test
