// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Skins and morph targets of glTF files, sound and damaged.
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scene/gltf_builder.h"
#include "scene/gltf_checks.h"

namespace stillray::gltf_skins_test {
namespace {

using nlohmann::json;
using test::ExpectBad;
using test::GltfBuilder;
using test::Loaded;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

const std::vector<uint8_t> kJoints = {0, 1, 0, 0, 1, 0, 0, 0, 1, 1, 0, 0};
const std::vector<float> kWeights = {0.5f, 0.5f, 0, 0, 1, 0, 0, 0, 0.25f, 0.75f, 0, 0};

std::vector<float> Matrices(const std::vector<float>& shifts) {
  std::vector<float> all;
  for (const float x : shifts) {
    all.insert(all.end(), {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, x, 0, 0, 1});
  }
  return all;
}

json& Attributes(GltfBuilder* builder) {
  return builder->json["meshes"][0]["primitives"][0]["attributes"];
}

/// A triangle on node 0 with the joints 1 and 2; 2 is a child of 1, one to its right.
GltfBuilder Skinned() {
  GltfBuilder builder;
  builder.AddTriangle();
  Attributes(&builder)["JOINTS_0"] = builder.AddAccessor(kJoints, test::kGltfUnsignedByte, "VEC4");
  Attributes(&builder)["WEIGHTS_0"] = builder.AddFloats(kWeights, "VEC4");
  builder.json["nodes"][0]["skin"] = 0;
  builder.json["nodes"][0]["translation"] = {7, 8, 9};
  builder.Add("nodes", {{"children", {2}}});
  builder.Add("nodes", {{"translation", {1, 0, 0}}});
  builder.Add("skins", {{"name", "bones"},
                        {"joints", {1, 2}},
                        {"skeleton", 1},
                        {"inverseBindMatrices", builder.AddFloats(Matrices({0, -1}), "MAT4")}});
  return builder;
}

TEST(GltfSkins, AreLoaded) {
  const Scene scene = Loaded(Skinned());
  ASSERT_EQ(scene.skins.size(), 1u);
  const Skin& skin = scene.skins[0];
  EXPECT_EQ(skin.name, "bones");
  EXPECT_THAT(skin.joints, ElementsAre(1, 2));
  EXPECT_EQ(skin.inverse_bind[1][3], vec4(-1, 0, 0, 1));
  ASSERT_EQ(scene.instances.size(), 1u);
  EXPECT_EQ(scene.instances[0].skin, 0);
  const Mesh& mesh = scene.meshes[0];
  EXPECT_EQ(mesh.influences, 4);
  // The joints of weights 0 are of no use, and become 0.
  EXPECT_THAT(mesh.joints, ElementsAre(0, 1, 0, 0, 1, 0, 0, 0, 1, 1, 0, 0));
  EXPECT_EQ(mesh.weights, kWeights);
  // The joints stand as bound: the triangle is where its positions are, not where its node is.
  EXPECT_EQ(SceneBounds(scene, 0).max, vec3(1, 1, 0));
  EXPECT_THAT(scene.warnings, Not(Contains(HasSubstr("skin"))));
}

TEST(GltfSkins, WeightsAndJointsOfAllFormats) {
  GltfBuilder builder = Skinned();
  Attributes(&builder)["JOINTS_0"] = builder.AddAccessor<uint16_t>(
      {0, 1, 0, 0, 1, 0, 0, 0, 1, 1, 0, 0}, test::kGltfUnsignedShort, "VEC4");
  Attributes(&builder)["WEIGHTS_0"] = builder.AddAccessor<uint8_t>(
      {51, 204, 0, 0, 255, 0, 0, 0, 0, 255, 0, 0}, test::kGltfUnsignedByte, "VEC4", true);
  Scene scene = Loaded(builder);
  EXPECT_NEAR(scene.meshes[0].weights[0], 0.2f, 1e-6f);
  EXPECT_NEAR(scene.meshes[0].weights[1], 0.8f, 1e-6f);
  Attributes(&builder)["WEIGHTS_0"] = builder.AddAccessor<uint16_t>(
      {13107, 52428, 0, 0, 65535, 0, 0, 0, 0, 65535, 0, 0}, test::kGltfUnsignedShort, "VEC4", true);
  scene = Loaded(builder);
  EXPECT_NEAR(scene.meshes[0].weights[0], 0.2f, 1e-6f);
  EXPECT_THAT(scene.warnings, Not(Contains(HasSubstr("WEIGHTS"))));
}

TEST(GltfSkins, UpToEightJointsPerVertex) {
  GltfBuilder builder = Skinned();
  Attributes(&builder)["JOINTS_1"] = builder.AddAccessor<uint8_t>(
      {1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}, test::kGltfUnsignedByte, "VEC4");
  Attributes(&builder)["WEIGHTS_0"] =
      builder.AddFloats({0.25f, 0.25f, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, "VEC4");
  Attributes(&builder)["WEIGHTS_1"] =
      builder.AddFloats({0.5f, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}, "VEC4");
  const Scene scene = Loaded(builder);
  EXPECT_EQ(scene.meshes[0].influences, 8);
  EXPECT_EQ(scene.meshes[0].joints[4], 1);
  EXPECT_EQ(scene.meshes[0].weights[4], 0.5f);
  EXPECT_EQ(scene.meshes[0].weights[8], 1.0f);
}

TEST(GltfSkins, BadWeightsAreMendedWithAWarning) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  GltfBuilder builder = Skinned();
  Attributes(&builder)["WEIGHTS_0"] =
      builder.AddFloats({2, 6, 0, 0, nan, 1, -3, 0, 0, 0, 0, 0}, "VEC4");
  const Scene scene = Loaded(builder);
  EXPECT_THAT(scene.meshes[0].weights, ElementsAre(0.25f, 0.75f, 0, 0, 0, 1, 0, 0, 1, 0, 0, 0));
  EXPECT_THAT(scene.warnings, Contains(HasSubstr("WEIGHTS_0: the weights of 1 vertices do not add "
                                                 "up to 1")));
  EXPECT_THAT(scene.warnings, Contains(HasSubstr("1 vertices are negative, NaN")));
  EXPECT_THAT(scene.warnings, Contains(HasSubstr("1 vertices are all 0")));
}

TEST(GltfSkins, FaultsAreNamed) {
  GltfBuilder builder = Skinned();
  builder.json["nodes"][0]["skin"] = 1;
  ExpectBad(builder, "nodes[0].skin: index 1");
  builder = Skinned();
  builder.json["skins"][0]["joints"] = json::array();
  ExpectBad(builder, "skins[0].joints: has 0 joints, expected 1 to");
  builder = Skinned();
  builder.json["skins"][0].erase("joints");
  ExpectBad(builder, "skins[0].joints: has 0 joints");
  builder = Skinned();
  builder.json["skins"][0]["joints"] = {1, 9};
  ExpectBad(builder, "skins[0].joints[1]: index 9 is out of range");
  builder = Skinned();
  builder.json["skins"][0]["joints"] = {1, 1};
  ExpectBad(builder, "skins[0].joints: names node 1 twice");
  builder = Skinned();
  builder.json["skins"][0]["skeleton"] = 5;
  ExpectBad(builder, "skins[0].skeleton: index 5");
  builder = Skinned();
  builder.json["scenes"] = {{{"nodes", {0}}}};
  ExpectBad(builder, "skins[0].joints: node 1 is not part of the scene");
  builder = Skinned();
  builder.json["skins"][0]["joints"] = {1};
  ExpectBad(builder, "primitives[0].JOINTS_0: joint 1 is out of range, skins[0] of nodes[0] has 1");
  builder = Skinned();
  builder.json["skins"][0]["inverseBindMatrices"] = builder.AddFloats(Matrices({0}), "MAT4");
  ExpectBad(builder, "skins[0].inverseBindMatrices: accessors[4] has 1 matrices for 2 joints");
  builder = Skinned();
  builder.json["skins"][0]["inverseBindMatrices"] = 0;
  ExpectBad(builder, "accessors[0] does not hold 4x4 matrices");
  builder = Skinned();
  builder.json["skins"][0]["inverseBindMatrices"] =
      builder.AddFloats(Matrices({0, std::numeric_limits<float>::infinity()}), "MAT4");
  ExpectBad(builder, "matrix 1 has components that are not finite");
}

TEST(GltfSkins, FaultsOfVerticesAreNamed) {
  GltfBuilder builder = Skinned();
  Attributes(&builder).erase("WEIGHTS_0");
  ExpectBad(builder, "attributes.WEIGHTS_0: missing, but there is JOINTS_0");
  builder = Skinned();
  Attributes(&builder).erase("JOINTS_0");
  ExpectBad(builder, "attributes.JOINTS_0: missing, but there is WEIGHTS_0");
  builder = Skinned();
  Attributes(&builder)["JOINTS_0"] = 0;
  ExpectBad(builder, "JOINTS_0: accessors[0] has 3 components, expected 4");
  builder = Skinned();
  Attributes(&builder)["JOINTS_0"] = Attributes(&builder)["WEIGHTS_0"];
  ExpectBad(builder, "JOINTS_0: is not of unsigned bytes or shorts");
  builder = Skinned();
  Attributes(&builder)["WEIGHTS_0"] = Attributes(&builder)["JOINTS_0"];
  ExpectBad(builder, "WEIGHTS_0: is not of floats or normalised");
  builder = Skinned();
  Attributes(&builder)["WEIGHTS_0"] = builder.AddFloats({1, 0, 0, 0}, "VEC4");
  ExpectBad(builder, "WEIGHTS_0: has 1 elements, POSITION has 3");
}

TEST(GltfSkins, MeshesWithoutJointsStandStill) {
  GltfBuilder builder = Skinned();
  Attributes(&builder).erase("JOINTS_0");
  Attributes(&builder).erase("WEIGHTS_0");
  const Scene scene = Loaded(builder);
  EXPECT_EQ(scene.instances[0].skin, -1);
  EXPECT_EQ(SceneBounds(scene, 0).max, vec3(8, 9, 9));
  EXPECT_THAT(scene.warnings, Contains(HasSubstr("has no JOINTS_0")));
}

TEST(GltfSkins, AMeshMayHaveSeveral) {
  GltfBuilder builder = Skinned();
  builder.Add("nodes", {{"translation", {0, 4, 0}}});
  builder.Add("nodes", json::object());
  builder.Add("skins", {{"joints", {3, 4}}});
  builder.Add("nodes", {{"mesh", 0}, {"skin", 1}});
  builder.Add("nodes", {{"mesh", 0}});
  const Scene scene = Loaded(builder);
  ASSERT_EQ(scene.instances.size(), 3u);
  EXPECT_EQ(scene.meshes.size(), 1u);
  EXPECT_EQ(scene.instances[1].skin, 1);
  EXPECT_EQ(scene.instances[2].skin, -1);
  EXPECT_EQ(scene.skins[1].inverse_bind[0], mat4(1.0f));
}

/// A triangle with normals and two morph targets, one of them sparse, on node 0.
GltfBuilder Morphing() {
  GltfBuilder builder;
  json& primitive = builder.AddTriangle();
  primitive["attributes"]["NORMAL"] = builder.AddFloats({0, 0, 1, 0, 0, 1, 0, 0, 1}, "VEC3");
  const int whole = builder.AddFloats({0, 0, 0, 0, 0, 2, 0, 0, 0}, "VEC3");
  const int normals = builder.AddFloats({0, 0, 0, 1, 0, 0, 0, 0, 0}, "VEC3");
  const int view = builder.AddView({2, 0, 0, 0});
  const int values = builder.AddFloats({0, 3, 0}, "VEC3");
  const int sparse = builder.Add(
      "accessors",
      {{"componentType", test::kGltfFloat},
       {"type", "VEC3"},
       {"count", 3},
       {"sparse",
        {{"count", 1},
         {"indices", {{"bufferView", view}, {"componentType", test::kGltfUnsignedByte}}},
         {"values",
          {{"bufferView",
            builder.json["accessors"][static_cast<size_t>(values)]["bufferView"]}}}}}});
  builder.json["meshes"][0]["primitives"][0]["targets"] = {
      {{"POSITION", whole}, {"NORMAL", normals}}, {{"POSITION", sparse}}};
  builder.json["meshes"][0]["weights"] = {0.5, 1};
  return builder;
}

TEST(GltfMorphs, AreLoaded) {
  Scene scene = Loaded(Morphing());
  const Mesh& mesh = scene.meshes[0];
  ASSERT_EQ(mesh.targets.size(), 2u);
  EXPECT_THAT(mesh.targets[0].vertices, ElementsAre(1u));
  EXPECT_THAT(mesh.targets[0].positions, ElementsAre(vec3(0, 0, 2)));
  EXPECT_THAT(mesh.targets[0].normals, ElementsAre(vec3(1, 0, 0)));
  EXPECT_TRUE(mesh.targets[0].tangents.empty());
  EXPECT_THAT(mesh.targets[1].vertices, ElementsAre(2u));
  EXPECT_THAT(mesh.targets[1].positions, ElementsAre(vec3(0, 3, 0)));
  EXPECT_THAT(scene.nodes[0].weights, ElementsAre(0.5f, 1.0f));
  EXPECT_EQ(SceneBounds(scene, 0).max, vec3(1, 4, 1));
  // The node's weights go before those of the mesh.
  GltfBuilder builder = Morphing();
  builder.json["nodes"][0]["weights"] = {0, 2};
  EXPECT_THAT(Loaded(builder).nodes[0].weights, ElementsAre(0.0f, 2.0f));
  builder.json["nodes"][0].erase("weights");
  builder.json["meshes"][0].erase("weights");
  EXPECT_THAT(Loaded(builder).nodes[0].weights, ElementsAre(0.0f, 0.0f));
}

void AnimateWeights(GltfBuilder* builder, const char* interpolation, int input, int output) {
  builder->json["animations"] = {
      {{"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "weights"}}}}}},
       {"samplers", {{{"input", input}, {"output", output}, {"interpolation", interpolation}}}}}};
}

TEST(GltfMorphs, WeightsAreAnimated) {
  GltfBuilder builder = Morphing();
  const int times = builder.AddFloats({0, 2}, "SCALAR");
  AnimateWeights(&builder, "LINEAR", times, builder.AddFloats({0, 0, 1, 3}, "SCALAR"));
  EXPECT_THAT(MorphWeights(Loaded(builder), 0, 1.0), ElementsAre(0.5f, 1.5f));
  AnimateWeights(
      &builder, "STEP", times,
      builder.AddAccessor<uint8_t>({0, 0, 255, 51}, test::kGltfUnsignedByte, "SCALAR", true));
  EXPECT_THAT(MorphWeights(Loaded(builder), 0, 2.0), ElementsAre(1.0f, 0.2f));
  AnimateWeights(&builder, "CUBICSPLINE", times,
                 builder.AddFloats({0, 0, 0, 2, 0, 0, 0, 0, 1, 4, 0, 0}, "SCALAR"));
  EXPECT_THAT(MorphWeights(Loaded(builder), 0, 1.0), ElementsAre(0.5f, 3.0f));
  AnimateWeights(&builder, "LINEAR", times, times);
  ExpectBad(builder, "output: accessors[6] has 2 elements of 1 components, expected 4 of 1");
}

TEST(GltfMorphs, FaultsAreNamed) {
  GltfBuilder builder = Morphing();
  builder.json["meshes"][0]["weights"] = {1};
  ExpectBad(builder, "meshes[0].weights: 1 weights, but the mesh has 2 morph targets");
  builder = Morphing();
  builder.json["nodes"][0]["weights"] = {1, 2, 3};
  ExpectBad(builder, "nodes[0].weights: 3 weights, but the mesh has 2");
  builder = Morphing();
  builder.json["nodes"][0]["weights"] = {1, "x"};
  ExpectBad(builder, "nodes[0].weights");
  builder = Morphing();
  json& targets = builder.json["meshes"][0]["primitives"][0]["targets"];
  targets[0]["POSITION"] = 77;
  ExpectBad(builder, "targets[0].POSITION: index 77");
  targets[0]["POSITION"] = builder.AddFloats({1, 2, 3}, "VEC3");
  ExpectBad(builder, "primitives[0].targets[0].POSITION: has 1 elements, POSITION has 3");
  targets = json::array();
  for (int i = 0; i < 1025; ++i) {
    targets.push_back({{"POSITION", 0}});
  }
  ExpectBad(builder, "targets: has 1025 morph targets, expected at most 1024");
  builder = Morphing();
  json other = builder.json["meshes"][0]["primitives"][0];
  other["targets"].erase(0);
  builder.json["meshes"][0]["primitives"].push_back(other);
  ExpectBad(builder, "primitives[1].targets: 1 morph targets, but meshes[0].primitives[0] has 2");
}

TEST(GltfMorphs, ChangesThatAreNotFiniteBecomeZero) {
  GltfBuilder builder = Morphing();
  const float nan = std::numeric_limits<float>::quiet_NaN();
  builder.json["meshes"][0]["primitives"][0]["targets"][0]["POSITION"] =
      builder.AddFloats({nan, 0, 0, 0, 0, 2, 0, 0, 0}, "VEC3");
  const Scene scene = Loaded(builder);
  EXPECT_THAT(scene.meshes[0].targets[0].vertices, ElementsAre(1u));
  EXPECT_THAT(scene.warnings, Contains(HasSubstr("targets[0].POSITION: 1 changes that are NaN")));
}

TEST(GltfMorphs, TrianglesThatOpenLaterStay) {
  GltfBuilder builder = Morphing();
  const int closed = builder.AddFloats({0, 0, 0, 1, 0, 0, 2, 0, 0}, "VEC3");
  Attributes(&builder)["POSITION"] = closed;
  EXPECT_EQ(Loaded(builder).TriangleCount(), 1u);
  Attributes(&builder).erase("NORMAL");
  EXPECT_EQ(Loaded(builder).meshes.at(0).normals[0], vec3(0, 1, 0));
}

TEST(GltfMorphs, TrianglesWithoutNormalsStayFlat) {
  GltfBuilder builder = Morphing();
  Attributes(&builder).erase("NORMAL");
  const Scene scene = Loaded(builder);
  EXPECT_TRUE(scene.meshes[0].flat_normals);
  EXPECT_TRUE(scene.meshes[0].targets[0].normals.empty());
}

TEST(GltfMorphs, ASmallFileCannotAskForMuch) {
  GltfBuilder builder;
  const int positions = builder.Add(
      "accessors", {{"componentType", test::kGltfFloat}, {"type", "VEC3"}, {"count", 100000}});
  builder.AddPrimitive({{"attributes", {{"POSITION", positions}}}});
  for (int i = 0; i < 100; ++i) {
    builder.json["meshes"][0]["primitives"][0]["targets"].push_back({{"POSITION", positions}});
  }
  ExpectBad(builder, "meshes[0].primitives[0]: asks for 10100000 elements");
}

TEST(GltfSkins, EveryFlippedByteIsSurvived) {
  for (const GltfBuilder& builder : {Skinned(), Morphing()}) {
    const std::vector<uint8_t> whole = builder.Glb();
    for (size_t i = 0; i < whole.size(); ++i) {
      for (const uint8_t flip : {0x01, 0x10, 0x80, 0xff}) {
        std::vector<uint8_t> glb = whole;
        glb[i] ^= flip;
        const Result<Scene> scene = LoadGltfFromMemory(glb.data(), glb.size(), "");
        EXPECT_TRUE(scene.ok() || !scene.status().message().empty());
      }
    }
  }
}

}  // namespace
}  // namespace stillray::gltf_skins_test
