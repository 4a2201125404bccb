// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scene/gltf_builder.h"
#include "scene/gltf_checks.h"

namespace stillray::gltf_meshes_test {
namespace {

using test::GltfBuilder;
using test::Loaded;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// Four corners of the unit square, in the order of a triangle strip.
const std::vector<float> kSquare = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0};

TEST(GltfMeshes, ATriangleWithoutNormalsGetsItsOwn) {
  GltfBuilder builder;
  builder.AddTriangle();
  const Scene scene = Loaded(builder);
  ASSERT_EQ(scene.meshes.size(), 1u);
  EXPECT_EQ(scene.TriangleCount(), 1u);
  EXPECT_THAT(scene.meshes[0].normals, ElementsAre(vec3(0, 0, 1), vec3(0, 0, 1), vec3(0, 0, 1)));
  EXPECT_THAT(scene.meshes[0].positions, ElementsAre(vec3(0, 0, 0), vec3(1, 0, 0), vec3(0, 1, 0)));
  // glTF's default material.
  ASSERT_EQ(scene.materials.size(), 1u);
  EXPECT_EQ(scene.materials[0].metallic, 1.0f);
}

TEST(GltfMeshes, FlatNormalsUnshareVertices) {
  // Two faces of a roof that share an edge.
  GltfBuilder builder;
  const int positions = builder.AddFloats({0, 0, 0, 0, 0, 1, 1, 1, 0, 1, 1, 1, 2, 0, 0}, "VEC3");
  const int indices =
      builder.AddAccessor<uint16_t>({0, 1, 2, 2, 3, 4}, test::kGltfUnsignedShort, "SCALAR");
  builder.AddPrimitive({{"attributes", {{"POSITION", positions}}}, {"indices", indices}});
  const Mesh mesh = Loaded(builder).meshes.at(0);
  ASSERT_EQ(mesh.positions.size(), 6u);
  EXPECT_THAT(mesh.indices, ElementsAre(0, 1, 2, 3, 4, 5));
  const float half = std::sqrt(0.5f);
  EXPECT_NEAR(mesh.normals[0].x, -half, 1e-6f);
  EXPECT_NEAR(mesh.normals[0].y, half, 1e-6f);
  EXPECT_NEAR(mesh.normals[5].x, half, 1e-6f);
}

TEST(GltfMeshes, StripsAndFansBecomeTrianglesThatFaceTheSameWay) {
  for (const int mode : {5, 6}) {
    GltfBuilder builder;
    const std::vector<float> fan = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
    const int positions = builder.AddFloats(mode == 5 ? kSquare : fan, "VEC3");
    builder.AddPrimitive({{"attributes", {{"POSITION", positions}}}, {"mode", mode}});
    const Scene scene = Loaded(builder);
    ASSERT_EQ(scene.TriangleCount(), 2u) << "mode " << mode;
    for (const vec3& normal : scene.meshes[0].normals) {
      EXPECT_EQ(normal, vec3(0, 0, 1)) << "mode " << mode;
    }
  }
}

TEST(GltfMeshes, PointsAndLinesAreLeftOut) {
  GltfBuilder builder;
  builder.AddTriangle()["mode"] = 1;
  builder.AddTriangle();
  const Scene scene = Loaded(builder);
  EXPECT_EQ(scene.TriangleCount(), 1u);
  EXPECT_THAT(scene.warnings,
              Contains(HasSubstr("meshes[0].primitives[0].mode: points and lines")));
}

TEST(GltfMeshes, ReadsSparseAccessors) {
  GltfBuilder builder;
  const int positions = builder.AddFloats({0, 0, 0, 1, 0, 0, 0, 1, 0}, "VEC3");
  const uint8_t index = 2;
  const int indices = builder.AddView({index, 0, 0, 0});
  const std::vector<float> value = {0, 5, 7};
  const uint8_t* bytes = reinterpret_cast<const uint8_t*>(value.data());
  const int values = builder.AddView({bytes, bytes + 12});
  builder.json["accessors"][positions]["sparse"] = {
      {"count", 1},
      {"indices", {{"bufferView", indices}, {"componentType", test::kGltfUnsignedByte}}},
      {"values", {{"bufferView", values}}}};
  builder.AddPrimitive({{"attributes", {{"POSITION", positions}}}});
  EXPECT_THAT(Loaded(builder).meshes.at(0).positions,
              ElementsAre(vec3(0, 0, 0), vec3(1, 0, 0), vec3(0, 5, 7)));
}

TEST(GltfMeshes, ASparseAccessorWithoutABufferStartsAtZero) {
  GltfBuilder builder;
  const int view = builder.AddView({1, 0, 2, 0});
  const std::vector<float> value = {3, 0, 0, 0, 3, 0};
  const uint8_t* bytes = reinterpret_cast<const uint8_t*>(value.data());
  const int values = builder.AddView({bytes, bytes + 24});
  const int positions = builder.Add(
      "accessors",
      {{"componentType", test::kGltfFloat},
       {"type", "VEC3"},
       {"count", 3},
       {"sparse",
        {{"count", 2},
         {"indices", {{"bufferView", view}, {"componentType", test::kGltfUnsignedShort}}},
         {"values", {{"bufferView", values}}}}}});
  builder.AddPrimitive({{"attributes", {{"POSITION", positions}}}});
  EXPECT_THAT(Loaded(builder).meshes.at(0).positions,
              ElementsAre(vec3(0, 0, 0), vec3(3, 0, 0), vec3(0, 3, 0)));
}

TEST(GltfMeshes, ReadsInterleavedAttributesByStride) {
  GltfBuilder builder;
  const std::vector<float> data = {0, 0, 0, 0.25f, 0.5f, 1, 0, 0, 0.75f, 1, 0, 1, 0, 0, 0};
  const uint8_t* bytes = reinterpret_cast<const uint8_t*>(data.data());
  const int view = builder.AddView({bytes, bytes + data.size() * 4});
  builder.json["bufferViews"][view]["byteStride"] = 20;
  const int positions = builder.AddViewAccessor(view, test::kGltfFloat, "VEC3", 3);
  const int uvs = builder.AddViewAccessor(view, test::kGltfFloat, "VEC2", 3);
  builder.json["accessors"][uvs]["byteOffset"] = 12;
  builder.AddPrimitive({{"attributes", {{"POSITION", positions}, {"TEXCOORD_0", uvs}}}});
  const Mesh mesh = Loaded(builder).meshes.at(0);
  EXPECT_EQ(mesh.positions[1], vec3(1, 0, 0));
  EXPECT_THAT(mesh.uv[0], ElementsAre(vec2(0.25f, 0.5f), vec2(0.75f, 1), vec2(0, 0)));
}

TEST(GltfMeshes, NormalisedIntegersBecomeFractions) {
  GltfBuilder builder;
  nlohmann::json& primitive = builder.AddTriangle();
  primitive["attributes"]["TEXCOORD_0"] = builder.AddAccessor<uint16_t>(
      {0, 65535, 13107, 0, 0, 0}, test::kGltfUnsignedShort, "VEC2", true);
  // Rows of three bytes would be unaligned: four bytes a row, three of them read.
  const int view = builder.AddView({255, 51, 0, 0, 0, 255, 102, 0, 0, 0, 0, 0});
  builder.json["bufferViews"][view]["byteStride"] = 4;
  const int colours = builder.AddViewAccessor(view, test::kGltfUnsignedByte, "VEC3", 3, true);
  builder.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = colours;
  const Mesh mesh = Loaded(builder).meshes.at(0);
  EXPECT_FLOAT_EQ(mesh.uv[0][0].y, 1.0f);
  EXPECT_FLOAT_EQ(mesh.uv[0][1].x, 0.2f);
  ASSERT_EQ(mesh.colors.size(), 3u);
  EXPECT_EQ(mesh.colors[0], vec4(1.0f, 0.2f, 0.0f, 1.0f));
  EXPECT_EQ(mesh.colors[1], vec4(0.0f, 1.0f, 0.4f, 1.0f));
}

TEST(GltfMeshes, SignedNormalisedIntegersReachMinusOne) {
  // KHR_mesh_quantization: both -128 and -127 are -1 (glTF 2.0, 3.6.2.2).
  GltfBuilder builder;
  builder.json["extensionsRequired"] = {"KHR_mesh_quantization"};
  const int positions = builder.AddAccessor<int8_t>({-128, 0, 0, 0, 0, -127, 0, 0, 0, 0, 127, 0},
                                                    test::kGltfByte, "VEC4", true);
  builder.json["accessors"][positions]["type"] = "VEC3";
  builder.json["bufferViews"][0]["byteStride"] = 4;
  builder.AddPrimitive({{"attributes", {{"POSITION", positions}}}});
  EXPECT_THAT(Loaded(builder).meshes.at(0).positions,
              ElementsAre(vec3(-1, 0, 0), vec3(0, -1, 0), vec3(0, 0, 1)));
}

TEST(GltfMeshes, ColoursOfFloatsWithAlpha) {
  GltfBuilder builder;
  const int colours = builder.AddFloats({0.5f, 0.25f, 0, 0.75f, 1, 1, 1, 1, 2, -1, 0, 1}, "VEC4");
  builder.AddTriangle()["attributes"]["COLOR_0"] = colours;
  const Scene scene = Loaded(builder);
  EXPECT_EQ(scene.meshes.at(0).colors[0], vec4(0.5f, 0.25f, 0.0f, 0.75f));
  EXPECT_EQ(scene.meshes.at(0).colors[2], vec4(1.0f, 0.0f, 0.0f, 1.0f));
  EXPECT_THAT(scene.warnings, Contains(HasSubstr("COLOR_0: values outside 0..1 were clamped")));
}

TEST(GltfMeshes, OnlyVerticesInUseAreKept) {
  // Two primitives of one shared array, as many exporters write them.
  GltfBuilder builder;
  std::vector<float> many(3 * 1000, 0.0f);
  for (size_t i = 0; i < 1000; ++i) {
    many[3 * i] = static_cast<float>(i);
    many[3 * i + 1] = static_cast<float>(i * i % 7);
  }
  const int positions = builder.AddFloats(many, "VEC3");
  const int normals = builder.AddFloats(std::vector<float>(3000, 1.0f), "VEC3");
  for (const std::vector<uint16_t>& corners :
       {std::vector<uint16_t>{999, 3, 500}, std::vector<uint16_t>{7, 9, 12}}) {
    const int indices = builder.AddAccessor(corners, test::kGltfUnsignedShort, "SCALAR");
    builder.AddPrimitive(
        {{"attributes", {{"POSITION", positions}, {"NORMAL", normals}}}, {"indices", indices}});
  }
  const Scene scene = Loaded(builder);
  ASSERT_EQ(scene.meshes.size(), 2u);
  ASSERT_EQ(scene.meshes[0].positions.size(), 3u);
  EXPECT_EQ(scene.meshes[0].positions[0].x, 3.0f);
  EXPECT_THAT(scene.meshes[0].indices, ElementsAre(2, 0, 1));
  EXPECT_EQ(scene.meshes[1].positions[2].x, 12.0f);
}

TEST(GltfMeshes, APrimitiveOfAMeshIsAMeshAndAnInstanceEach) {
  GltfBuilder builder;
  builder.AddTriangle();
  nlohmann::json& mesh = builder.json["meshes"][0];
  mesh["name"] = "pair";
  mesh["primitives"].push_back(nlohmann::json(mesh["primitives"][0]));
  builder.Add("nodes", {{"mesh", 0}, {"translation", {5, 0, 0}}});
  const Scene scene = Loaded(builder);
  EXPECT_EQ(scene.meshes.size(), 2u);
  EXPECT_EQ(scene.meshes[1].name, "pair");
  ASSERT_EQ(scene.instances.size(), 4u);
  EXPECT_EQ(scene.TriangleCount(), 4u);
  EXPECT_EQ(scene.instances[0].node, 0);
  EXPECT_EQ(scene.instances[1].mesh, 1);
  EXPECT_EQ(scene.instances[2].node, 1);
}

// Nodes times primitives: 159 600 instances of a few kilobytes, which take 900 bytes each later.
TEST(GltfMeshes, FewBytesMakeNoMillionsOfInstances) {
  GltfBuilder file;
  file.AddTriangle();
  nlohmann::json& primitives = file.json["meshes"][0]["primitives"];
  const nlohmann::json primitive = primitives[0];
  while (primitives.size() < 400) {
    primitives.push_back(primitive);
  }
  while (file.json["nodes"].size() < 400) {
    const int node = file.Add("nodes", {{"mesh", 0}});
    file.json["scenes"][0]["nodes"].push_back(node);
  }
  const Status status = file.Load().status();
  EXPECT_EQ(status.code(), StatusCode::kUnsupported);
  EXPECT_THAT(status.message(), HasSubstr("the nodes place 159600 primitives, at most 1"));
  // A real scene has more bytes: the same with vertices of its own.
  file.AddFloats(std::vector<float>(300'000, 0.0f), "VEC3");
  EXPECT_EQ(file.Load()->instances.size(), 159'600u);
}

TEST(GltfMeshes, TrianglesWithoutAreaOrPlaceAreLeftOut) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float infinity = std::numeric_limits<float>::infinity();
  GltfBuilder builder;
  const int positions =
      builder.AddFloats({0, 0, 0, 1, 0, 0, 0, 1, 0, nan, 0, 0, 0, infinity, 0, 2, 0, 0}, "VEC3");
  const int indices = builder.AddAccessor<uint8_t>({0, 1, 2, 0, 1, 3, 1, 2, 4, 0, 1, 5, 1, 1, 2},
                                                   test::kGltfUnsignedByte, "SCALAR");
  builder.AddPrimitive({{"attributes", {{"POSITION", positions}}}, {"indices", indices}});
  const Scene scene = Loaded(builder);
  EXPECT_EQ(scene.TriangleCount(), 1u);
  EXPECT_EQ(scene.meshes.at(0).positions.size(), 3u);
  EXPECT_THAT(scene.warnings, Contains(HasSubstr("meshes[0].primitives[0]: 2 triangles with "
                                                 "positions that are NaN")));
  EXPECT_THAT(scene.warnings, Contains(HasSubstr("2 triangles without area")));
  EXPECT_EQ(SceneBounds(scene, 0).max, vec3(1, 1, 0));
}

TEST(GltfMeshes, NormalsAreMendedAndNormalised) {
  GltfBuilder builder;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const int normals = builder.AddFloats({0, 0, 0, 0, 3, 4, nan, 0, 1}, "VEC3");
  builder.AddTriangle()["attributes"]["NORMAL"] = normals;
  const Scene scene = Loaded(builder);
  const Mesh& mesh = scene.meshes.at(0);
  EXPECT_EQ(mesh.normals[0], vec3(0, 0, 1));
  EXPECT_FLOAT_EQ(mesh.normals[1].y, 0.6f);
  EXPECT_FLOAT_EQ(mesh.normals[1].z, 0.8f);
  EXPECT_EQ(mesh.normals[2], vec3(0, 0, 1));
  EXPECT_THAT(scene.warnings, Contains(HasSubstr("NORMAL: 2 normals")));
}

TEST(GltfMeshes, GlbAndTextGiveTheSameScene) {
  GltfBuilder builder;
  builder.AddTriangle();
  const std::vector<uint8_t> glb = builder.Glb();
  const Result<Scene> scene = LoadGltfFromMemory(glb.data(), glb.size(), "");
  ASSERT_TRUE(scene.ok()) << scene.status().message();
  EXPECT_EQ(scene->meshes.at(0).positions, Loaded(builder).meshes.at(0).positions);
}

TEST(GltfMeshes, NothingIsWarnedAboutInAPlainFile) {
  GltfBuilder builder;
  builder.AddTriangle();
  builder.Add("cameras", {{"type", "perspective"}, {"perspective", {{"yfov", 1.0}}}});
  builder.Add("nodes", {{"camera", 0}});
  builder.UseMaterial({{"emissiveFactor", {1, 1, 1}}});
  EXPECT_THAT(Loaded(builder).warnings, IsEmpty());
}

}  // namespace
}  // namespace stillray::gltf_meshes_test
