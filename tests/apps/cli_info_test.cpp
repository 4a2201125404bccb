// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "apps/program.h"
#include "stillray/io.h"

namespace stillray::cli_info_test {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::ContainsRegex;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;

class CliInfo : public testing::Test {
 protected:
  /// 4 x 3 pixels: a main picture with one NaN, one infinity and two negatives, a depth of 2 with
  /// one value of 5, and ids.
  std::string WriteSample() const {
    ExrImage exr;
    exr.width = 4;
    exr.height = 3;
    Image3 colour(4, 3);
    for (int c = 0; c < 3; ++c) {
      colour[c].Fill(1.0f);
    }
    colour[0](0, 0) = std::nanf("");
    colour[1](1, 0) = std::numeric_limits<float>::infinity();
    colour[2](2, 0) = -3.0f;
    colour[2](3, 0) = -1.0f;
    exr.Add("", PixelType::kFloat, colour);
    Image1 depth(4, 3);
    depth.Fill(2.0f);
    depth(3, 2) = 5.0f;
    exr.Add("depth.Z", PixelType::kHalf, depth);
    Plane<uint32_t> id(4, 3);
    id.Fill(4000000000u);
    exr.Add("id", id);
    exr.attributes["stillray.note"] = "one\ntwo \xff";
    const std::string path = folder_ / "sample.exr";
    EXPECT_TRUE(WriteExr(path, exr).ok());
    return path;
  }

  void ExpectFailure(const ProgramRun& run, const std::string& what) const {
    EXPECT_EQ(run.exit_code, 2);
    EXPECT_THAT(run.errors, AllOf(StartsWith("stillray: error: "), HasSubstr(what)));
    EXPECT_EQ(std::count(run.errors.begin(), run.errors.end(), '\n'), 1) << run.errors;
    EXPECT_THAT(run.output, IsEmpty());
  }

  std::string WriteBytes(const std::string& name, const std::string& bytes) const {
    std::ofstream(folder_ / name, std::ios::binary) << bytes;
    return folder_ / name;
  }

  const TemporaryFolder folder_;
};

TEST_F(CliInfo, ExrAsText) {
  const std::string path = WriteSample();
  const ProgramRun run = RunProgram({"info", path});
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_THAT(run.errors, IsEmpty());
  EXPECT_THAT(run.output, HasSubstr(path + ": EXR, 4 x 3 pixels"));
  EXPECT_THAT(run.output, HasSubstr("zip, scanlines"));
  EXPECT_THAT(run.output, HasSubstr("(0, 0) - (3, 2)"));
  EXPECT_THAT(run.output, ContainsRegex("depth +Z +half +2 +2.25 +5 +0 +0 +0\n"));
  EXPECT_THAT(run.output, ContainsRegex("R G B id +float.uint32 "));
  EXPECT_THAT(run.output, HasSubstr("stillray.note = one two "));
}

TEST_F(CliInfo, ExrAsJson) {
  const std::string path = WriteSample();
  const ProgramRun run = RunProgram({"info", path, "--json", folder_ / "info.json"});
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_THAT(run.output, HasSubstr("EXR, 4 x 3"));
  const json info = json::parse(ReadText(folder_ / "info.json"));
  EXPECT_EQ(info["kind"], "picture");
  EXPECT_EQ(info["width"], 4);
  EXPECT_EQ(info["compression"], "zip");
  EXPECT_EQ(info["data_window"]["x_max"], 3);
  const auto layer = [&](const std::string& name) {
    for (const json& entry : info["layers"]) {
      if (entry["name"] == name) {
        return entry;
      }
    }
    ADD_FAILURE() << "no layer " << name;
    return json();
  };
  const json main_layer = layer("");
  EXPECT_EQ(main_layer["nan"], 1);
  EXPECT_EQ(main_layer["infinite"], 1);
  EXPECT_EQ(main_layer["negative"], 2);
  EXPECT_EQ(main_layer["max"], 4000000000.0);
  const json& blue = main_layer["channels"][2];
  EXPECT_EQ(blue["name"], "B");
  EXPECT_EQ(blue["type"], "float");
  EXPECT_EQ(blue["min"], -3.0);
  EXPECT_EQ(blue["max"], 1.0);
  EXPECT_DOUBLE_EQ(blue["mean"], (10.0 - 3.0 - 1.0) / 12.0);
  const json& red = main_layer["channels"][0];
  EXPECT_EQ(red["mean"], 1.0);  // without the NaN
  EXPECT_DOUBLE_EQ(layer("depth")["mean"], 2.25);
  EXPECT_THAT(info["attributes"]["stillray.note"].get<std::string>(), StartsWith("one\ntwo "));
}

TEST_F(CliInfo, JsonAloneOnStandardOutput) {
  const ProgramRun run = RunProgram({"info", WriteSample(), "--json", "-"});
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_EQ(json::parse(run.output)["format"], "EXR");
}

TEST_F(CliInfo, NothingFiniteHasNoRange) {
  ExrImage exr;
  exr.width = 2;
  exr.height = 1;
  Image1 values(2, 1);
  values.Fill(std::numeric_limits<float>::infinity());
  exr.Add("depth.Z", PixelType::kFloat, values);
  ASSERT_TRUE(WriteExr(folder_ / "a.exr", exr).ok());
  const json info = json::parse(RunProgram({"info", folder_ / "a.exr", "--json", "-"}).output);
  EXPECT_TRUE(info["layers"][0]["mean"].is_null());
  EXPECT_EQ(info["layers"][0]["infinite"], 2);
  EXPECT_THAT(RunProgram({"info", folder_ / "a.exr"}).output,
              ContainsRegex("depth +Z +float +- +- +- +0 +2 +0\n"));
}

TEST_F(CliInfo, OtherPictures) {
  ASSERT_TRUE(WritePng(folder_ / "a.png", Rgb8Image{2, 1, {255, 0, 0, 255, 255, 0}}).ok());
  ProgramRun run = RunProgram({"info", folder_ / "a.png"});
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_THAT(run.output, AllOf(HasSubstr("PNG, 2 x 1 pixels"), HasSubstr("decoded from sRGB")));
  const json info = json::parse(RunProgram({"info", folder_ / "a.png", "--json", "-"}).output);
  EXPECT_EQ(info["layers"][0]["channels"][1]["mean"], 0.5);
  run = RunProgram({"info", WriteBytes("a.hdr", "#?RADIANCE\n\n-Y 1 +X 1\n\x80\x80\x80\x84")});
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_THAT(run.output, AllOf(HasSubstr("HDR, 1 x 1 pixels"), ContainsRegex(" 8 +8 +8 ")));
}

TEST_F(CliInfo, BuiltinScene) {
  const ProgramRun run =
      RunProgram({"info", "builtin:cornell", "--json", folder_ / "cornell.json"});
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_THAT(run.errors, IsEmpty());
  EXPECT_THAT(run.output, AllOf(HasSubstr("builtin:cornell: scene"), ContainsRegex("triangles +36"),
                                ContainsRegex("camera +0")));
  const json info = json::parse(ReadText(folder_ / "cornell.json"));
  EXPECT_EQ(info["kind"], "scene");
  EXPECT_EQ(info["emissive_triangles"], 2);
  EXPECT_EQ(info["texture_bytes"].get<int64_t>() % 4, 0);
  EXPECT_GT(info["bounds"]["max"][1].get<double>(), info["bounds"]["min"][1].get<double>());
  EXPECT_EQ(info["cameras"].size(), 1u);
}

TEST_F(CliInfo, GltfFile) {
  // One triangle in a buffer of 36 bytes, outside of the view. Of the three solids one scatters:
  // another has an infinite attenuation distance, the third no colour.
  const std::string path = WriteBytes("a.gltf", R"({"asset": {"version": "2.0"},
    "scene": 0, "scenes": [{"nodes": [0, 1]}], "nodes": [{"mesh": 0}, {"mesh": 0}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
    "materials": [
      {"extensions": {
        "KHR_materials_volume": {"thicknessFactor": 1, "attenuationDistance": 2,
                                 "attenuationColor": [0.5, 0.5, 0.5]},
        "KHR_materials_volume_scatter": {"multiscatterColor": [0, 0.5, 0]}}},
      {"extensions": {
        "KHR_materials_volume": {"thicknessFactor": 1},
        "KHR_materials_volume_scatter": {"multiscatterColor": [0, 0.5, 0]}}},
      {"extensions": {
        "KHR_materials_volume": {"thicknessFactor": 1, "attenuationDistance": 2}}}],
    "buffers": [{"byteLength": 36, "uri":
      "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}],
    "bufferViews": [{"buffer": 0, "byteLength": 36}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
                   "min": [0, 0, 0], "max": [1, 1, 0]}]})");
  const ProgramRun run = RunProgram({"info", path, "--json", "-"});
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  const json info = json::parse(run.output);
  EXPECT_EQ(info["triangles"], 2);
  EXPECT_EQ(info["stored_triangles"], 1);
  EXPECT_EQ(info["instances"], 2);
  EXPECT_EQ(info["bounds"]["max"], json::array({1.0, 1.0, 0.0}));
  EXPECT_EQ(info["animation_seconds"], 0.0);
  EXPECT_EQ(info["scattering_materials"], 1);
}

TEST_F(CliInfo, WhatDeforms) {
  // The same triangle, with itself as a morph target, and on one node with a skin of one joint.
  const std::string path = WriteBytes("b.gltf", R"({"asset": {"version": "2.0"},
    "nodes": [{"mesh": 0}, {"mesh": 0}, {"mesh": 1, "skin": 0}, {}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "targets": [{"POSITION": 0}]}]},
               {"primitives": [{"attributes": {"POSITION": 0, "JOINTS_0": 1, "WEIGHTS_0": 2}}]}],
    "skins": [{"joints": [3]}],
    "buffers": [{"byteLength": 36, "uri":
      "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}],
    "bufferViews": [{"buffer": 0, "byteLength": 36}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
                  {"componentType": 5121, "count": 3, "type": "VEC4"},
                  {"componentType": 5126, "count": 3, "type": "VEC4"}]})");
  ProgramRun run = RunProgram({"info", path});
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.output, HasSubstr("1 instances by skins, 2 by morph targets"));
  run = RunProgram({"info", path, "--json", "-"});
  const json info = json::parse(run.output);
  EXPECT_EQ(info["skinned_instances"], 1);
  EXPECT_EQ(info["morphed_instances"], 2);
}

TEST_F(CliInfo, HelpHasExamples) {
  const ProgramRun run = RunProgram({"info", "--help"});
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_THAT(run.output, HasSubstr("stillray info frame.0001.exr"));
}

TEST_F(CliInfo, BadInputIsNamed) {
  ExpectFailure(RunProgram({"info", folder_ / "none.exr"}), "none.exr: there is no such file");
  ExpectFailure(RunProgram({"info", folder_ / "none.glb"}), "none.glb");
  ExpectFailure(RunProgram({"info", folder_.path()}), "is a folder");
  ExpectFailure(RunProgram({"info", "builtin:none"}), "cornell");
  ExpectFailure(RunProgram({"info", WriteBytes("a.txt", "hello")}), "a.txt: is not a picture");
  ExpectFailure(RunProgram({"info", WriteBytes("empty.png", "")}), "empty.png: is empty");
  ExpectFailure(RunProgram({"info", WriteBytes("bad.glb", "glTFxxxxxxxxxxx")}), "bad.glb");
  const std::string whole = ReadText(WriteSample());
  ExpectFailure(RunProgram({"info", WriteBytes("cut.exr", whole.substr(0, whole.size() - 20))}),
                "cut.exr: is a damaged EXR file");
}

TEST_F(CliInfo, SequencesAreNotFiles) {
  WriteBytes("a.0001.exr", "");
  WriteBytes("a.0002.exr", "");
  ExpectFailure(RunProgram({"info", folder_ / "a.####.exr"}), "not a sequence of 2, such as ");
}

TEST_F(CliInfo, FailedWritesAreReported) {
  const std::string path = WriteSample();
  ExpectFailure(RunProgram({"info", path, "--json", folder_ / "none/info.json"}), "none");
  ExpectFailure(RunProgram({"info", path, "--json", "/dev/full"}), "No space left on device");
  const ProgramRun run = RunProgram({"info", path}, "/dev/full");
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.errors, HasSubstr("standard output"));
}

TEST_F(CliInfo, MissingAndUnknownArguments) {
  EXPECT_EQ(RunProgram({"info"}).exit_code, 2);
  EXPECT_EQ(RunProgram({"info", "a.exr", "--nonsense"}).exit_code, 2);
  EXPECT_EQ(RunProgram({"info", "a.exr", "b.exr"}).exit_code, 2);
}

}  // namespace
}  // namespace stillray::cli_info_test
