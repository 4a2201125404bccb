// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Deformation against computations in double precision.
#include "scene/deform.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

namespace stillray::deform_test {
namespace {

using dvec3 = glm::dvec3;
using ::testing::ElementsAre;

void ExpectNear(vec3 found, dvec3 expected, double tolerance) {
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(static_cast<double>(found[k]), expected[k], tolerance) << "component " << k;
  }
}

/// Rotation by `angle` about z, in double precision.
dvec3 TurnAboutZ(dvec3 p, double angle) {
  return {p.x * std::cos(angle) - p.y * std::sin(angle),
          p.x * std::sin(angle) + p.y * std::cos(angle), p.z};
}

vec4 QuaternionAboutZ(double angle) {
  return {0, 0, static_cast<float>(std::sin(0.5 * angle)),
          static_cast<float>(std::cos(0.5 * angle))};
}

/// A bar from (0, 0) to (2, 0) with six pairs of vertices; joint 0 at its start, joint 1, a child,
/// at its middle. The weight of joint 1 grows from 0 to 1 along it. Node 2 has the mesh.
Scene Bar() {
  Scene scene;
  scene.nodes.resize(3);
  scene.nodes[1].parent = 0;
  scene.nodes[1].local.translation = vec3(1, 0, 0);
  scene.nodes[2].local.translation = vec3(50, 60, 70);  // a skin does not depend on it
  Skin skin;
  skin.joints = {0, 1};
  skin.inverse_bind = {mat4(1.0f), mat4(1.0f)};
  skin.inverse_bind[1][3] = vec4(-1, 0, 0, 1);
  scene.skins.push_back(skin);
  Mesh mesh;
  mesh.influences = 4;
  for (int i = 0; i < 6; ++i) {
    for (const float y : {-0.25f, 0.25f}) {
      mesh.positions.push_back(vec3(0.4f * static_cast<float>(i), y, 0.1f));
      mesh.normals.push_back(vec3(0, y * 4, 0));
      mesh.tangents.push_back(vec4(1, 0, 0, -1));
      const float weight = 0.2f * static_cast<float>(i);
      mesh.joints.insert(mesh.joints.end(), {1, 0, 0, 0});
      mesh.weights.insert(mesh.weights.end(), {weight, 1.0f - weight, 0, 0});
    }
  }
  for (uint32_t i = 0; i < 5; ++i) {
    mesh.indices.insert(mesh.indices.end(), {2 * i, 2 * i + 2, 2 * i + 3});
    mesh.indices.insert(mesh.indices.end(), {2 * i, 2 * i + 3, 2 * i + 1});
  }
  scene.meshes.push_back(mesh);
  scene.instances.push_back({0, 2, 0});
  return scene;
}

DeformedMesh DeformedAt(const Scene& scene, double seconds = 0) {
  const Instance& instance = scene.instances[0];
  DeformedMesh out;
  Deform(scene.meshes[0], PoseOf(scene, instance, NodeTransforms(scene, seconds), seconds), &out);
  return out;
}

TEST(DeformTest, ABoundPoseIsTheRestPose) {
  const Scene scene = Bar();
  const DeformedMesh mesh = DeformedAt(scene);
  for (size_t i = 0; i < mesh.positions.size(); ++i) {
    ExpectNear(mesh.positions[i], dvec3(scene.meshes[0].positions[i]), 1e-6);
    ExpectNear(mesh.normals[i], dvec3(scene.meshes[0].normals[i]), 1e-6);
  }
  EXPECT_EQ(mesh.tangents[0].w, -1.0f);
}

TEST(DeformTest, ABarOfTwoJointsBendsAsComputedByHand) {
  Scene scene = Bar();
  const double first = 0.3;
  const double second = 1.1;
  scene.nodes[0].local.rotation = QuaternionAboutZ(first);
  scene.nodes[0].local.translation = vec3(0, 3, 0);
  scene.nodes[1].local.rotation = QuaternionAboutZ(second);
  const DeformedMesh mesh = DeformedAt(scene);
  for (size_t i = 0; i < mesh.positions.size(); ++i) {
    const Mesh& rest = scene.meshes[0];
    const double weight = static_cast<double>(rest.weights[4 * i]);
    const dvec3 p(rest.positions[i]);
    const dvec3 by_first = TurnAboutZ(p, first) + dvec3(0, 3, 0);
    const dvec3 elbow = TurnAboutZ(dvec3(1, 0, 0), first) + dvec3(0, 3, 0);
    const dvec3 by_second = elbow + TurnAboutZ(p - dvec3(1, 0, 0), first + second);
    ExpectNear(mesh.positions[i], by_first * (1 - weight) + by_second * weight, 2e-6);
    // A sum of two rotations about one axis is a rotation times a factor: normals follow it.
    const dvec3 n(rest.normals[i]);
    const dvec3 normal =
        TurnAboutZ(n, first) * (1 - weight) + TurnAboutZ(n, first + second) * weight;
    ExpectNear(mesh.normals[i], normal / std::sqrt(glm::dot(normal, normal)), 2e-6);
  }
}

TEST(DeformTest, RotationsBlendLinearly) {
  // Half a turn and none, in equal parts, meet in the axis.
  Scene scene = Bar();
  scene.nodes[1].local.rotation = QuaternionAboutZ(3.14159265358979);
  scene.meshes[0].positions[0] = vec3(1.0f, 0.25f, 0.1f);
  scene.meshes[0].weights[0] = scene.meshes[0].weights[1] = 0.5f;
  ExpectNear(DeformedAt(scene).positions[0], dvec3(1, 0, 0.1), 1e-6);
}

TEST(DeformTest, NormalsFollowTheCofactorsOfTheSkin) {
  Scene scene = Bar();
  scene.nodes[0].local.scale = vec3(2, 0.5f, -1.5f);  // mirrors
  scene.nodes[1].local.rotation = vec4(0.2f, 0.4f, 0.1f, 0.8888194f);
  for (size_t i = 0; i < scene.meshes[0].normals.size(); ++i) {
    scene.meshes[0].normals[i] = glm::normalize(vec3(0.3f, 1.0f, 0.2f + static_cast<float>(i)));
  }
  const DeformedMesh mesh = DeformedAt(scene);
  const std::vector<mat4> nodes = NodeTransforms(scene, 0);
  for (size_t i = 0; i < mesh.normals.size(); ++i) {
    const double weight = static_cast<double>(scene.meshes[0].weights[4 * i]);
    const glm::dmat4 skin =
        glm::dmat4(nodes[0]) * (1 - weight) +
        glm::dmat4(nodes[1]) * glm::dmat4(scene.skins[0].inverse_bind[1]) * weight;
    const dvec3 expected =
        glm::transpose(glm::inverse(glm::dmat3(skin))) * dvec3(scene.meshes[0].normals[i]);
    ExpectNear(mesh.normals[i], expected / std::sqrt(glm::dot(expected, expected)), 3e-6);
  }
  EXPECT_EQ(PoseOrientation(PoseOf(scene, scene.instances[0], nodes, 0)), -1.0f);
}

TEST(DeformTest, NormalsStayPerpendicularToTheDeformedSurface) {
  // Two tangents of the rest surface at each vertex, moved as points by differences.
  Scene scene = Bar();
  scene.nodes[0].local.scale = vec3(1, 2, 0.7f);
  scene.nodes[1].local.rotation = QuaternionAboutZ(0.6);
  const DeformedMesh mesh = DeformedAt(scene);
  Scene moved = scene;
  for (const dvec3& along : {dvec3(1, 0, 0), dvec3(0, 0, 1)}) {
    constexpr float kStep = 0.01f;
    for (vec3& p : moved.meshes[0].positions) {
      p += vec3(along) * kStep;
    }
    const DeformedMesh other = DeformedAt(moved);
    for (size_t i = 0; i < mesh.positions.size(); ++i) {
      const dvec3 tangent = dvec3(other.positions[i]) - dvec3(mesh.positions[i]);
      EXPECT_NEAR(glm::dot(tangent / static_cast<double>(kStep), dvec3(mesh.normals[i])), 0, 1e-4);
    }
    moved = scene;
  }
}

/// A triangle with two targets, whose weights are animated.
Scene Morphed(Interpolation interpolation, std::vector<float> weights) {
  Scene scene;
  Mesh mesh;
  mesh.positions = {vec3(0, 0, 0), vec3(1, 0, 0), vec3(0, 1, 0)};
  mesh.normals.assign(3, vec3(0, 0, 1));
  mesh.tangents.assign(3, vec4(1, 0, 0, 1));
  mesh.indices = {0, 1, 2};
  mesh.targets.resize(2);
  mesh.targets[0].vertices = {1};
  mesh.targets[0].positions = {vec3(0, 0, 2)};
  mesh.targets[0].normals = {vec3(-3, 0, 0)};
  mesh.targets[0].tangents = {vec3(0, 0, 1)};
  mesh.targets[1].vertices = {1, 2};
  mesh.targets[1].positions = {vec3(0, 4, 0), vec3(8, 0, 0)};
  scene.meshes.push_back(mesh);
  scene.nodes.emplace_back();
  scene.nodes[0].weights = {0.5f, 0.25f};
  scene.instances.push_back({0, 0, -1});
  AnimationChannel channel;
  channel.node = 0;
  channel.property = AnimatedProperty::kWeights;
  channel.interpolation = interpolation;
  channel.times = {1.0f, 3.0f};
  channel.weights = std::move(weights);
  scene.animation.push_back(channel);
  return scene;
}

TEST(DeformTest, MorphTargetsAddUp) {
  Scene scene = Morphed(Interpolation::kLinear, {});
  scene.animation.clear();
  EXPECT_TRUE(MayDeform(scene, scene.instances[0]));
  EXPECT_FALSE(HasAnimatedWeights(scene, scene.instances[0]));
  const DeformedMesh mesh = DeformedAt(scene);
  ExpectNear(mesh.positions[0], dvec3(0, 0, 0), 0);
  ExpectNear(mesh.positions[1], dvec3(1, 1, 1), 1e-6);
  ExpectNear(mesh.positions[2], dvec3(2, 1, 0), 1e-6);
  ExpectNear(mesh.normals[1], dvec3(-1.5, 0, 1) / std::sqrt(3.25), 1e-6);
  ExpectNear(mesh.normals[2], dvec3(0, 0, 1), 0);
  ExpectNear(vec3(mesh.tangents[1]), dvec3(1, 0, 0.5) / std::sqrt(1.25), 1e-6);
  scene.nodes[0].weights = {0.0f, 0.0f};
  EXPECT_FALSE(MayDeform(scene, scene.instances[0]));
}

TEST(DeformTest, WeightsAreInterpolated) {
  Scene scene = Morphed(Interpolation::kLinear, {0, 1, 2, 5});
  EXPECT_THAT(MorphWeights(scene, 0, 0.0), ElementsAre(0.0f, 1.0f));
  EXPECT_THAT(MorphWeights(scene, 0, 1.5), ElementsAre(0.5f, 2.0f));
  EXPECT_THAT(MorphWeights(scene, 0, 9.0), ElementsAre(2.0f, 5.0f));
  ExpectNear(DeformedAt(scene, 1.5).positions[1], dvec3(1, 8, 1), 1e-6);
  scene.animation[0].interpolation = Interpolation::kStep;
  EXPECT_THAT(MorphWeights(scene, 0, 2.9), ElementsAre(0.0f, 1.0f));
  EXPECT_DOUBLE_EQ(scene.AnimationLength(), 3.0);
  // In-tangents, values, out-tangents of two weights each; between the keys, 2 s apart, at half.
  scene = Morphed(Interpolation::kCubicSpline, {9, 9, 1, 0, 2, 0, -1, 4, 5, 8, 9, 9});
  EXPECT_THAT(MorphWeights(scene, 0, 1.0), ElementsAre(1.0f, 0.0f));
  EXPECT_THAT(MorphWeights(scene, 0, 2.0),
              ElementsAre(0.5f * (1 + 5) + 0.125f * 2 * (2 + 1), 0.5f * 8 + 0.125f * 2 * (0 - 4)));
  EXPECT_EQ(NodeTransforms(scene, 2.0)[0], mat4(1.0f));
}

TEST(DeformTest, FlatNormalsFollowTheTriangles) {
  Scene scene = Morphed(Interpolation::kLinear, {1, 0, 1, 0});
  scene.meshes[0].flat_normals = true;
  const DeformedMesh mesh = DeformedAt(scene);  // (0,0,0) (1,0,2) (0,1,0)
  for (const vec3& normal : mesh.normals) {
    ExpectNear(normal, dvec3(-2, 0, 1) / std::sqrt(5.0), 1e-6);
  }
}

TEST(DeformTest, BoundsAreThoseOfTheDeformedMesh) {
  const Scene scene = Morphed(Interpolation::kLinear, {0, 0, 1, 1});
  EXPECT_EQ(SceneBounds(scene, 0).max, vec3(1, 1, 0));
  EXPECT_EQ(SceneBounds(scene, 3).max, vec3(8, 4, 2));
  Scene bar = Bar();
  bar.nodes[0].local.translation = vec3(0, 10, 0);
  EXPECT_NEAR(SceneBounds(bar, 0).max.y, 10.25f, 1e-5f);
  EXPECT_NEAR(SceneBounds(bar, 0).max.x, 2.0f, 1e-5f);
}

TEST(DeformTest, TheNumberOfThreadsDoesNotMatter) {
  Scene scene = Bar();
  scene.nodes[1].local.rotation = QuaternionAboutZ(0.7);
  Mesh& mesh = scene.meshes[0];
  mesh.flat_normals = false;
  mesh.tangents.clear();
  for (int i = 0; i < 20000; ++i) {
    mesh.positions.push_back(mesh.positions[static_cast<size_t>(i % 12)] * 1.01f);
    mesh.normals.push_back(vec3(mesh.normals[static_cast<size_t>(i % 12)]));
    mesh.joints.insert(mesh.joints.end(), {1, 0, 0, 0});
    mesh.weights.insert(mesh.weights.end(), {0.3f, 0.7f, 0, 0});
  }
  DeformedMesh one;
  {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
    one = DeformedAt(scene);
  }
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 4);
  const DeformedMesh four = DeformedAt(scene);
  EXPECT_EQ(one.positions, four.positions);
  EXPECT_EQ(one.normals, four.normals);
}

}  // namespace
}  // namespace stillray::deform_test
