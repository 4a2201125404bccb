// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Every kind of damage gives its status and a line that names the culprit.
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scene/gltf_builder.h"
#include "scene/gltf_checks.h"

namespace stillray::gltf_damage_test {
namespace {

using nlohmann::json;
using test::ExpectBad;
using test::ExpectError;
using test::GltfBuilder;
using ::testing::HasSubstr;

GltfBuilder Triangle() {
  GltfBuilder builder;
  builder.AddTriangle();
  return builder;
}

/// A triangle with 16-bit indices: accessor 0 holds them, 1 the positions.
GltfBuilder Indexed(const std::vector<uint16_t>& indices) {
  GltfBuilder builder;
  builder.AddAccessor(indices, test::kGltfUnsignedShort, "SCALAR");
  builder.AddTriangle()["indices"] = 0;
  return builder;
}

TEST(GltfDamage, EmptyAndWrongFiles) {
  ExpectError(LoadGltfFromMemory(nullptr, 0, ""), StatusCode::kBadData, "the file is empty");
  ExpectError(test::LoadText("{"), StatusCode::kBadData, "not valid JSON");
  ExpectError(test::LoadText("[1, 2]"), StatusCode::kBadData, "not an object");
  ExpectError(test::LoadText("{}"), StatusCode::kBadData, "asset: missing");
  ExpectError(test::LoadText(R"({"asset": {"version": "1.0"}})"), StatusCode::kUnsupported,
              "'1.0'");
  ExpectError(test::LoadText(R"({"asset": {"version": 2}})"), StatusCode::kBadData,
              "asset.version: expected a string, found number");
  ExpectError(test::LoadText(R"({"asset": {"version": "2.0"}})"), StatusCode::kBadData,
              "the scene has no triangles");
  ExpectError(test::LoadText(std::string(100000, '[')), StatusCode::kBadData, "nested deeper");
}

TEST(GltfDamage, EveryTruncationOfAGlbIsAnError) {
  const std::vector<uint8_t> glb = Triangle().Glb();
  for (size_t size = 0; size < glb.size(); ++size) {
    const Result<Scene> scene = LoadGltfFromMemory(glb.data(), size, "");
    ASSERT_FALSE(scene.ok()) << size << " of " << glb.size() << " bytes";
  }
  ExpectError(LoadGltfFromMemory(glb.data(), glb.size() - 1, ""), StatusCode::kBadData,
              "truncated .glb: its header says");
}

TEST(GltfDamage, EveryFlippedByteOfAGlbIsSurvived) {
  const std::vector<uint8_t> whole = Triangle().Glb();
  for (size_t i = 0; i < whole.size(); ++i) {
    for (const uint8_t flip : {0x01, 0x10, 0x80, 0xff}) {
      std::vector<uint8_t> glb = whole;
      glb[i] ^= flip;
      const Result<Scene> scene = LoadGltfFromMemory(glb.data(), glb.size(), "");
      EXPECT_TRUE(scene.ok() || !scene.status().message().empty());
    }
  }
}

TEST(GltfDamage, IndicesOutOfRange) {
  ExpectBad(Indexed({0, 1, 3}),
            "meshes[0].primitives[0].indices: index 3 at position 2 is out of range");
  GltfBuilder builder = Triangle();
  builder.json["nodes"][0]["mesh"] = 5;
  ExpectBad(builder, "nodes[0].mesh: index 5 is out of range, the file has 1 meshes");
  builder = Triangle();
  builder.json["meshes"][0]["primitives"][0]["material"] = 0;
  ExpectBad(builder, "meshes[0].primitives[0].material: index 0");
  builder = Triangle();
  builder.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = -1;
  ExpectBad(builder, "POSITION: expected a whole number >= 0, found -1");
  builder = Triangle();
  builder.json["scene"] = 3;
  builder.json["scenes"] = {{{"nodes", {0}}}};
  ExpectBad(builder, "scene: index 3");
}

TEST(GltfDamage, AccessorsBeyondTheirBuffers) {
  GltfBuilder builder = Triangle();
  builder.json["accessors"][0]["count"] = 4;
  ExpectBad(builder, "accessors[0]: 4 elements end at byte 48 of bufferViews[0], which has 36");
  builder = Triangle();
  builder.json["accessors"][0]["byteOffset"] = 4;
  ExpectBad(builder, "accessors[0]: 3 elements end at byte 40");
  builder = Triangle();
  builder.json["bufferViews"][0]["byteOffset"] = 4;
  ExpectBad(builder, "bufferViews[0]: bytes 4 to 40 do not lie in buffers[0], which has 36");
  builder = Triangle();
  builder.json["bufferViews"][0]["byteLength"] = 9007199254740991;
  ExpectBad(builder, "bufferViews[0]");
  builder = Triangle();
  builder.json["bufferViews"][0]["buffer"] = 1;
  ExpectBad(builder, "bufferViews[0].buffer: index 1");
  builder = Triangle();
  builder.json["bufferViews"][0]["byteStride"] = 8;
  ExpectBad(builder, "accessors[0]: elements of 12 bytes overlap");
  builder = Triangle();
  builder.json["bufferViews"][0]["byteStride"] = 13;
  ExpectBad(builder, "bufferViews[0].byteStride: 13");
}

TEST(GltfDamage, AbsurdCounts) {
  GltfBuilder builder = Triangle();
  builder.json["accessors"][0]["count"] = 9007199254740991;
  ExpectBad(builder, "9007199254740991");
  builder = Triangle();
  builder.json["accessors"][0]["count"] = 3000000;
  builder.json["accessors"][0].erase("bufferView");
  ExpectBad(builder, "accessors[0].count: 3000000 elements without data");
  builder = Triangle();
  builder.json["accessors"][0]["count"] = 0;
  ExpectBad(builder, "accessors[0].count: 0 is outside");
}

TEST(GltfDamage, ASmallFileCannotAskForMuchBySayingItOften) {
  GltfBuilder builder;
  const int positions = builder.Add(
      "accessors", {{"componentType", test::kGltfFloat}, {"type", "VEC3"}, {"count", 900000}});
  builder.Add("meshes", json::object());
  builder.Add("nodes", {{"mesh", 0}});
  for (int i = 0; i < 100; ++i) {
    builder.json["meshes"][0]["primitives"].push_back({{"attributes", {{"POSITION", positions}}}});
  }
  ExpectBad(builder, "meshes[0].primitives[4]: asks for 900000 elements");
}

TEST(GltfDamage, TypesThatDoNotFit) {
  GltfBuilder builder = Triangle();
  builder.json["accessors"][0]["componentType"] = 5124;
  ExpectBad(builder, "accessors[0].componentType: 5124");
  builder = Triangle();
  builder.json["accessors"][0]["type"] = "VEC2";
  ExpectBad(builder, "meshes[0].primitives[0].POSITION: accessors[0] has 2 components");
  builder = Triangle();
  builder.json["accessors"][0]["type"] = "MAT3";
  ExpectBad(builder, "accessors[0].type: 'MAT3'");
  builder = Indexed({0, 1, 2});
  builder.json["accessors"][0]["componentType"] = test::kGltfShort;
  ExpectBad(builder, "does not hold unsigned integers");
  builder = Triangle();
  builder.json["meshes"][0]["primitives"][0]["mode"] = 9;
  ExpectBad(builder, "meshes[0].primitives[0].mode: 9");
  builder = Triangle();
  builder.json["meshes"] = "none";
  ExpectBad(builder, "meshes: expected an array, found string");
  builder = Triangle();
  builder.json["nodes"][0] = 7;
  ExpectBad(builder, "nodes[0]: expected an object, found number");
}

TEST(GltfDamage, AttributesOfDifferentLength) {
  GltfBuilder builder = Triangle();
  const int normals = builder.AddFloats({0, 0, 1, 0, 0, 1}, "VEC3");
  builder.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = normals;
  ExpectBad(builder, "meshes[0].primitives[0].NORMAL: has 2 elements, POSITION has 3");
}

TEST(GltfDamage, SparseAccessors) {
  GltfBuilder builder = Triangle();
  const int view = builder.AddView({2, 1, 0, 0});
  json& sparse = builder.json["accessors"][0]["sparse"];
  sparse = {{"count", 2},
            {"indices", {{"bufferView", view}, {"componentType", test::kGltfUnsignedByte}}},
            {"values", {{"bufferView", 0}}}};
  ExpectBad(builder, "accessors[0].sparse.indices: index 1 at position 1 is not increasing");
  sparse["indices"]["byteOffset"] = 3;
  ExpectBad(builder, "accessors[0].sparse.indices: 2 elements end at byte 5");
  sparse["count"] = 4;
  ExpectBad(builder, "accessors[0].sparse.count: 4 is outside 1..3");
  sparse["count"] = 1;
  sparse["indices"]["byteOffset"] = 0;
  sparse["values"] = json::object();
  ExpectBad(builder, "accessors[0].sparse.values.bufferView: missing");
}

TEST(GltfDamage, NodesThatAreNoTrees) {
  GltfBuilder builder = Triangle();
  builder.Add("nodes", {{"children", {2}}});
  builder.Add("nodes", {{"children", {1}}});
  ExpectBad(builder, "nodes[1]: is its own ancestor");
  builder = Triangle();
  builder.json["nodes"][0]["children"] = {0};
  ExpectBad(builder, "nodes[0]: is its own ancestor");
  builder = Triangle();
  builder.Add("nodes", {{"children", {0}}});
  builder.Add("nodes", {{"children", {0}}});
  ExpectBad(builder, "nodes[2].children: node 0 already is a child of node 1");
  builder = Triangle();
  builder.Add("nodes", {{"children", {0}}});
  builder.json["scenes"] = {{{"nodes", {0}}}};
  ExpectBad(builder, "scenes[0].nodes: node 0 is no root");
  builder.json["scenes"] = {{{"nodes", {1, 1}}}};
  ExpectBad(builder, "scenes[0].nodes: names node 1 twice");
}

TEST(GltfDamage, NumbersThatAreNone) {
  GltfBuilder builder = Triangle();
  builder.json["nodes"][0]["translation"] = {1e300, 0, 0};
  ExpectBad(builder, "nodes[0].translation[0]: 1e+300 is too large");
  builder.json["nodes"][0]["translation"] = {1, 0};
  ExpectBad(builder, "nodes[0].translation: expected 3 numbers, found 2");
  builder.json["nodes"][0]["translation"] = {1, 0, "x"};
  ExpectBad(builder, "nodes[0].translation[2]: expected a number, found string");
  builder.json["nodes"][0]["translation"] = {1e30, 0, 0};
  ExpectBad(builder, "nodes[0]: its transform");
  builder = Triangle();
  builder.json["nodes"][0]["scale"] = {1e15, 1e15, 1e15};
  builder.Add("nodes", {{"children", {0}}, {"scale", {1e15, 1, 1}}});
  ExpectBad(builder, "nodes[0]: its transform");
}

TEST(GltfDamage, PositionsThatAreAllNan) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  GltfBuilder builder;
  const int positions = builder.AddFloats(std::vector<float>(9, nan), "VEC3");
  builder.AddPrimitive({{"attributes", {{"POSITION", positions}}}});
  ExpectBad(builder, "the scene has no triangles");
}

// A scene within the limit whose camera, placed to show all of it, would be beyond the range of
// rays.
TEST(GltfDamage, TooLargeForACameraThatSeesAll) {
  const auto triangle = [](float size) {
    GltfBuilder builder;
    const int positions = builder.AddFloats({-size, -size, 0, size, -size, 0, 0, size, 0}, "VEC3");
    builder.AddPrimitive({{"attributes", {{"POSITION", positions}}}});
    return builder;
  };
  const Status status = triangle(4.9e17f).Load().status();
  EXPECT_EQ(status.code(), StatusCode::kBadData);
  EXPECT_THAT(status.message(), HasSubstr("no camera, and one that sees the whole scene would"));
  EXPECT_TRUE(triangle(1e17f).Load().ok());
}

TEST(GltfDamage, CamerasLightsAndMaterials) {
  GltfBuilder builder = Triangle();
  builder.Add("cameras", {{"type", "perspective"}, {"perspective", {{"yfov", 0}}}});
  builder.json["nodes"][0]["camera"] = 0;
  ExpectBad(builder, "cameras[0].perspective.yfov: 0 is no angle");
  builder = Triangle();
  builder.json["nodes"][0]["extensions"]["KHR_lights_punctual"]["light"] = 0;
  ExpectBad(builder, "KHR_lights_punctual.light: index 0");
  builder = Triangle();
  builder.UseMaterial({{"alphaMode", "GLASS"}});
  ExpectBad(builder, "materials[0].alphaMode: 'GLASS'");
  builder = Triangle();
  builder.UseMaterial({{"emissiveTexture", {{"index", 4}}}});
  ExpectBad(builder, "materials[0].emissiveTexture.index: index 4");
}

GltfBuilder Animated(const std::vector<float>& times, const std::vector<float>& values) {
  GltfBuilder builder = Triangle();
  const int input = builder.AddFloats(times, "SCALAR");
  const int output = builder.AddFloats(values, "VEC3");
  builder.Add("animations",
              {{"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "scale"}}}}}},
               {"samplers", {{{"input", input}, {"output", output}}}}});
  return builder;
}

TEST(GltfDamage, Animations) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  ExpectBad(Animated({0, 0}, {1, 1, 1, 1, 1, 1}),
            "animations[0].samplers[0].input: time 0 of keyframe 1 does not lie after 0");
  ExpectBad(Animated({-1}, {1, 1, 1}), "input: time -1 of keyframe 0");
  ExpectBad(Animated({nan}, {1, 1, 1}), "input: time nan of keyframe 0");
  ExpectBad(Animated({0, 1}, {1, 1, 1}), "output: accessors[2] has 1 elements of 3 components");
  ExpectBad(Animated({0}, {1, nan, 1}), "output: value nan of element 0");
  GltfBuilder builder = Animated({0}, {1, 1, 1});
  builder.json["animations"][0]["samplers"][0]["interpolation"] = "MAGIC";
  ExpectBad(builder, "interpolation: 'MAGIC'");
  builder = Animated({0}, {1, 1, 1});
  builder.json["animations"][0]["channels"][0]["sampler"] = 1;
  ExpectBad(builder, "animations[0].channels[0].sampler: index 1");
  builder = Animated({0}, {1, 1, 1});
  builder.json["animations"][0]["channels"][0]["target"]["node"] = 9;
  ExpectBad(builder, "animations[0].channels[0].target.node: index 9");
}

TEST(GltfDamage, TextFromFilesIsMadePrintable) {
  GltfBuilder builder = Triangle();
  builder.json["extensionsRequired"] = {std::string("evil\n\x1b[31m") + std::string(1000, 'x')};
  const Result<Scene> scene = builder.Load();
  ExpectError(scene, StatusCode::kUnsupported, "evil\\n\\x1b[31m");
  EXPECT_LT(scene.status().message().size(), 400u);
}

}  // namespace
}  // namespace stillray::gltf_damage_test
