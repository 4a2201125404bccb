// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scene/gltf_builder.h"
#include "scene/gltf_checks.h"

namespace stillray::gltf_nodes_test {
namespace {

using nlohmann::json;
using test::GltfBuilder;
using test::Loaded;
using ::testing::Contains;
using ::testing::HasSubstr;

constexpr float kSqrtHalf = 0.70710678f;

int FindNode(const Scene& scene, const std::string& name) {
  for (size_t i = 0; i < scene.nodes.size(); ++i) {
    if (scene.nodes[i].name == name) {
      return static_cast<int>(i);
    }
  }
  ADD_FAILURE() << "no node " << name;
  return 0;
}

mat4 WorldOf(const Scene& scene, const std::string& name, double seconds = 0) {
  return NodeTransforms(scene, seconds)[static_cast<size_t>(FindNode(scene, name))];
}

void ExpectNear(vec3 a, vec3 b) {
  EXPECT_NEAR(a.x, b.x, 1e-5f);
  EXPECT_NEAR(a.y, b.y, 1e-5f);
  EXPECT_NEAR(a.z, b.z, 1e-5f);
}

/// A triangle, and a chain of nodes in which children come before their parents.
GltfBuilder Chain() {
  GltfBuilder builder;
  builder.AddTriangle();
  builder.Add("nodes", {{"name", "hand"}, {"translation", {1, 0, 0}}});
  builder.Add("nodes", {{"name", "arm"}, {"children", {1}}, {"scale", {2, 2, 2}}});
  builder.Add("nodes", {{"name", "body"},
                        {"children", {2}},
                        {"rotation", {0, 0, kSqrtHalf, kSqrtHalf}},
                        {"translation", {10, 0, 0}}});
  return builder;
}

TEST(GltfNodes, WorldTransformsOfAHierarchy) {
  const Scene scene = Loaded(Chain());
  // Moved by 1 along x, doubled to 2, turned to y, moved by 10 along x.
  ExpectNear(vec3(WorldOf(scene, "hand")[3]), vec3(10, 2, 0));
  ExpectNear(vec3(WorldOf(scene, "hand") * vec4(1, 0, 0, 1)), vec3(10, 4, 0));
  for (size_t i = 0; i < scene.nodes.size(); ++i) {
    EXPECT_LT(scene.nodes[i].parent, static_cast<int>(i));
  }
}

TEST(GltfNodes, AMatrixIsTakenColumnByColumn) {
  GltfBuilder builder = Chain();
  builder.json["nodes"][3] = {{"name", "body"},
                              {"children", {2}},
                              {"matrix", {0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 10, 0, 0, 1}}};
  ExpectNear(vec3(WorldOf(Loaded(builder), "hand")[3]), vec3(10, 2, 0));
}

TEST(GltfNodes, RotationsAreNormalised) {
  GltfBuilder builder = Chain();
  builder.json["nodes"][3]["rotation"] = {0, 0, 5, 5};
  ExpectNear(vec3(WorldOf(Loaded(builder), "hand")[3]), vec3(10, 2, 0));
}

TEST(GltfNodes, OnlyTheChosenSceneIsLoaded) {
  GltfBuilder builder = Chain();
  builder.AddTriangle();
  builder.json["scenes"] = {{{"nodes", {3}}}, {{"name", "second"}, {"nodes", {4}}}};
  builder.json["scene"] = 1;
  const Scene scene = Loaded(builder);
  EXPECT_EQ(scene.name, "second");
  EXPECT_EQ(scene.instances.size(), 1u);
  EXPECT_EQ(scene.meshes.size(), 1u);
}

TEST(GltfNodes, CamerasAreRead) {
  GltfBuilder builder = Chain();
  builder.Add("cameras", {{"type", "orthographic"}, {"orthographic", json::object()}});
  builder.Add("cameras", {{"type", "perspective"},
                          {"name", "main"},
                          {"perspective", {{"yfov", 0.7}, {"aspectRatio", 1.5}}}});
  builder.Add("nodes", {{"camera", 0}});
  builder.Add("nodes", {{"name", "stand"}, {"camera", 1}});
  const Scene scene = Loaded(builder);
  ASSERT_EQ(scene.cameras.size(), 1u);
  EXPECT_EQ(scene.cameras[0].name, "main");
  EXPECT_EQ(scene.cameras[0].node, FindNode(scene, "stand"));
  EXPECT_FLOAT_EQ(scene.cameras[0].yfov, 0.7f);
  EXPECT_FLOAT_EQ(scene.cameras[0].aspect, 1.5f);
  EXPECT_THAT(scene.warnings, Contains(HasSubstr("cameras[0].type: 'orthographic'")));
}

TEST(GltfNodes, WithoutACameraOneIsMadeThatSeesEverything) {
  GltfBuilder builder;
  builder.AddTriangle();
  builder.json["nodes"][0]["translation"] = {100, 0, 0};
  const Scene scene = Loaded(builder);
  ASSERT_EQ(scene.cameras.size(), 1u);
  EXPECT_THAT(scene.warnings, Contains(HasSubstr("no perspective camera")));
  const mat4 view =
      glm::inverse(NodeTransforms(scene, 0)[static_cast<size_t>(scene.cameras[0].node)]);
  const float slope = std::tan(0.5f * scene.cameras[0].yfov);
  for (const vec3& p : {vec3(100, 0, 0), vec3(101, 0, 0), vec3(100, 1, 0)}) {
    const vec3 q(view * vec4(p, 1.0f));
    EXPECT_LT(q.z, 0.0f);
    EXPECT_LT(std::abs(q.x), -q.z * slope);
    EXPECT_LT(std::abs(q.y), -q.z * slope);
  }
}

TEST(GltfNodes, PunctualLights) {
  GltfBuilder builder = Chain();
  builder.json["extensionsUsed"] = {"KHR_lights_punctual"};
  builder.json["extensions"]["KHR_lights_punctual"]["lights"] = {
      {{"type", "point"}, {"color", {1, 0.5, 0.25}}, {"intensity", 8}, {"range", 30}},
      {{"type", "spot"},
       {"name", "beam"},
       {"spot", {{"innerConeAngle", 0.1}, {"outerConeAngle", 0.4}}}},
      {{"type", "directional"}, {"intensity", 3}}};
  for (int i = 0; i < 3; ++i) {
    builder.Add("nodes", {{"name", "light " + std::to_string(i)},
                          {"extensions", {{"KHR_lights_punctual", {{"light", i}}}}}});
  }
  const Scene scene = Loaded(builder);
  ASSERT_EQ(scene.lights.size(), 3u);
  EXPECT_EQ(scene.lights[0].type, LightType::kPoint);
  EXPECT_EQ(scene.lights[0].intensity, vec3(8, 4, 2));
  EXPECT_EQ(scene.lights[0].range, 30.0f);
  EXPECT_EQ(scene.lights[0].node, FindNode(scene, "light 0"));
  EXPECT_EQ(scene.lights[1].name, "beam");
  EXPECT_FLOAT_EQ(scene.lights[1].inner_cone_angle, 0.1f);
  EXPECT_FLOAT_EQ(scene.lights[1].outer_cone_angle, 0.4f);
  EXPECT_TRUE(std::isinf(scene.lights[1].range));
  EXPECT_EQ(scene.lights[2].type, LightType::kDirectional);
  EXPECT_EQ(scene.lights[2].intensity, vec3(3));
}

TEST(GltfNodes, TheEnvironmentIsThatOfTheScene) {
  GltfBuilder builder;
  builder.AddTriangle();
  builder.json["scenes"] = {
      {{"nodes", {0}},
       {"extras", {{"environment", {{"type", "constant"}, {"radiance", {1, 2, 0.5}}}}}}}};
  EXPECT_EQ(Loaded(builder).environment.radiance, vec3(1, 2, 0.5f));
  builder.json["scenes"][0]["extras"] = {{"environment", "sunny"}};
  const Scene other = Loaded(builder);
  EXPECT_EQ(other.environment.radiance, vec3(1.0f)) << "no light at all: one is added";
  EXPECT_THAT(other.warnings, Contains(HasSubstr("has no light")));
  builder.json["scenes"][0]["extras"] = {{"environment", {{"type", "map"}}}};
  EXPECT_THAT(Loaded(builder).warnings,
              Contains(HasSubstr("scenes[0].extras.environment.type: 'map' is unknown")));
}

TEST(GltfNodes, LensOfACamera) {
  GltfBuilder builder;
  builder.AddTriangle();
  nlohmann::json camera = {{"type", "perspective"}, {"perspective", {{"yfov", 0.8}, {"znear", 1}}}};
  builder.json["cameras"] = nlohmann::json::array({camera});
  builder.json["nodes"][0]["camera"] = 0;
  EXPECT_EQ(Loaded(builder).cameras[0].lens.radius, 0.0f);
  nlohmann::json& lens = builder.json["cameras"][0]["extras"]["lens"];
  lens = {{"aperture", 0.05}, {"f_number", 2.8}, {"focus", 3.5}, {"blades", 6}, {"rotation", 15}};
  const Lens found = Loaded(builder).cameras[0].lens;
  EXPECT_EQ(found.radius, 0.05f);
  EXPECT_EQ(found.f_number, 2.8f);
  EXPECT_EQ(found.focus, 3.5f);
  EXPECT_EQ(found.blades, 6);
  EXPECT_EQ(found.rotation, 15.0f);
  EXPECT_EQ(found.mask, -1);
  lens = "a lens of the author's";
  EXPECT_EQ(Loaded(builder).cameras[0].lens.radius, 0.0f);
  for (const auto& [name, value] : {std::pair{"aperture", -1.0},
                                    {"f_number", 0.0},
                                    {"focus", 0.0},
                                    {"focus", -2.0},
                                    {"blades", 2.0},
                                    {"mask", 0.0}}) {
    lens = nlohmann::json::object();
    lens[name] = value;
    if (value == 2.0 || std::string(name) == "mask") {
      lens[name] = static_cast<int>(value);
    }
    const std::string text = builder.Text();
    const Result<Scene> scene =
        LoadGltfFromMemory(reinterpret_cast<const uint8_t*>(text.data()), text.size(), "");
    EXPECT_EQ(scene.status().code(), StatusCode::kBadData) << name;
    EXPECT_THAT(scene.status().message(), HasSubstr(std::string("extras.lens.") + name));
  }
}

TEST(GltfNodes, DarknessThatTheFileAsksForIsKept) {
  GltfBuilder builder;
  builder.AddTriangle();
  builder.json["scenes"] = {
      {{"nodes", {0}},
       {"extras", {{"environment", {{"type", "constant"}, {"radiance", {0, 0, 0}}}}}}}};
  EXPECT_EQ(Loaded(builder).environment.radiance, vec3(0.0f));
}

/// Adds an animation with one channel.
void AddChannel(GltfBuilder* builder, int node, const char* path, const char* interpolation,
                int input, int output) {
  builder->Add(
      "animations",
      {{"channels", {{{"sampler", 0}, {"target", {{"node", node}, {"path", path}}}}}},
       {"samplers", {{{"input", input}, {"output", output}, {"interpolation", interpolation}}}}});
}

TEST(GltfAnimations, SeveralAreMerged) {
  GltfBuilder builder = Chain();
  const int times = builder.AddFloats({0, 2}, "SCALAR");
  AddChannel(&builder, 3, "translation", "LINEAR", times,
             builder.AddFloats({10, 0, 0, 20, 0, 0}, "VEC3"));
  AddChannel(&builder, 2, "scale", "STEP", times, builder.AddFloats({2, 2, 2, 3, 3, 3}, "VEC3"));
  const Scene scene = Loaded(builder);
  EXPECT_EQ(scene.animation.size(), 2u);
  EXPECT_DOUBLE_EQ(scene.AnimationLength(), 2.0);
  ExpectNear(vec3(WorldOf(scene, "hand", 0)[3]), vec3(10, 2, 0));
  ExpectNear(vec3(WorldOf(scene, "hand", 1)[3]), vec3(15, 2, 0));
  ExpectNear(vec3(WorldOf(scene, "hand", 2)[3]), vec3(20, 3, 0));
}

TEST(GltfAnimations, RotationsMayBeNormalisedIntegers) {
  GltfBuilder builder = Chain();
  const int times = builder.AddFloats({0, 1}, "SCALAR");
  const int values = builder.AddAccessor<int16_t>({0, 0, 0, 32767, 0, 0, 23170, 23170},
                                                  test::kGltfShort, "VEC4", true);
  AddChannel(&builder, 3, "rotation", "LINEAR", times, values);
  const Scene scene = Loaded(builder);
  ExpectNear(vec3(WorldOf(scene, "hand", 0)[3]), vec3(12, 0, 0));
  ExpectNear(vec3(WorldOf(scene, "hand", 1)[3]), vec3(10, 2, 0));
}

TEST(GltfAnimations, CubicSplinesHaveThreeValuesPerKey) {
  GltfBuilder builder = Chain();
  const int times = builder.AddFloats({0, 2}, "SCALAR");
  const int values =
      builder.AddFloats({0, 0, 0, 1, 0, 0, 3, 0, 0, -1, 0, 0, 5, 0, 0, 0, 0, 0}, "VEC3");
  AddChannel(&builder, 3, "translation", "CUBICSPLINE", times, values);
  ExpectNear(vec3(WorldOf(Loaded(builder), "body", 1)[3]), vec3(4, 0, 0));
}

TEST(GltfAnimations, ANodeWithAMatrixIsTakenApart) {
  GltfBuilder builder = Chain();
  // A quarter turn about z, doubled, mirrored in x, at (1, 2, 3).
  builder.json["nodes"][3] = {{"name", "body"},
                              {"matrix", {0, -2, 0, 0, -2, 0, 0, 0, 0, 0, 2, 0, 1, 2, 3, 1}}};
  const mat4 before = WorldOf(Loaded(builder), "body");
  const int times = builder.AddFloats({0}, "SCALAR");
  AddChannel(&builder, 3, "translation", "STEP", times, builder.AddFloats({1, 2, 3}, "VEC3"));
  const Scene scene = Loaded(builder);
  const mat4 after = WorldOf(scene, "body");
  for (int column = 0; column < 4; ++column) {
    ExpectNear(vec3(after[column]), vec3(before[column]));
  }
  EXPECT_THAT(scene.warnings, Contains(HasSubstr("animations[0].channels[0].target.node")));
}

TEST(GltfAnimations, WeightsAndUnknownPathsAreLeftOut) {
  GltfBuilder builder = Chain();
  const int times = builder.AddFloats({0}, "SCALAR");
  AddChannel(&builder, 3, "weights", "STEP", times, times);
  AddChannel(&builder, 3, "pointer", "STEP", times, times);
  const Scene scene = Loaded(builder);
  EXPECT_TRUE(scene.animation.empty());
  EXPECT_THAT(scene.warnings, Contains(HasSubstr("has no morph targets")));
  EXPECT_THAT(scene.warnings, Contains(HasSubstr("'pointer' is not supported")));
}

TEST(GltfAnimations, OfTwoChannelsForOneThingTheFirstCounts) {
  GltfBuilder builder = Chain();
  const int times = builder.AddFloats({0}, "SCALAR");
  AddChannel(&builder, 3, "scale", "STEP", times, builder.AddFloats({4, 4, 4}, "VEC3"));
  AddChannel(&builder, 3, "scale", "STEP", times, builder.AddFloats({9, 9, 9}, "VEC3"));
  const Scene scene = Loaded(builder);
  ASSERT_EQ(scene.animation.size(), 1u);
  EXPECT_EQ(scene.animation[0].values[0].x, 4.0f);
  EXPECT_THAT(scene.warnings, Contains(HasSubstr("animations[1].channels[0].target")));
}

}  // namespace
}  // namespace stillray::gltf_nodes_test
