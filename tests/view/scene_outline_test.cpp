// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "view/scene_outline.h"

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace stillray::view::scene_outline_test {
namespace {

class SceneOutlineFile : public ::testing::Test {
 protected:
  SceneOutlineFile() {
    std::string name = (std::filesystem::temp_directory_path() / "stillray-XXXXXX").string();
    folder_ = mkdtemp(name.data());
  }
  ~SceneOutlineFile() override {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }
  std::string Write(const std::string& bytes) const {
    const std::string path = (folder_ / "scene.glb").string();
    std::ofstream(path, std::ios::binary) << bytes;
    return path;
  }

 private:
  std::filesystem::path folder_;
};

/// A .glb with this JSON, and `told` as the length in its header.
std::string Glb(const std::string& json, uint32_t told) {
  std::string bytes = "glTF";
  const auto add = [&](uint32_t word) {
    for (int i = 0; i < 4; ++i) {
      bytes += static_cast<char>(word >> (8 * i));
    }
  };
  add(2);
  add(static_cast<uint32_t>(20 + json.size()));
  add(told);
  return bytes + "JSON" + json;
}

constexpr const char* kJson =
    R"({"textures": [{}, {}], "meshes": [{}], "asset": {"version": "2.0"}})";

TEST_F(SceneOutlineFile, CountsWhatIsInBothKindsOfFiles) {
  for (const std::string& bytes :
       {std::string(kJson), Glb(kJson, static_cast<uint32_t>(std::string(kJson).size()))}) {
    const SceneOutline outline = OutlineOf(Write(bytes));
    EXPECT_EQ(outline.textures, 2u);
    EXPECT_EQ(outline.meshes, 1u);
    EXPECT_EQ(ToText(outline), "2 textures and 1 mesh");
  }
}

TEST_F(SceneOutlineFile, KnowsNothingOfDamagedFiles) {
  const std::string nested(100000, '[');
  for (const std::string& bytes :
       {std::string(), std::string("glTF"), std::string(kJson).substr(0, 30), Glb(kJson, 12),
        Glb(kJson, 0xffffffff).substr(0, 40), nested, std::string("[1, 2, 3, 4, 5, 6, 7, 8]"),
        std::string(R"({"textures": 7, "meshes": "many"}      )")}) {
    EXPECT_EQ(ToText(OutlineOf(Write(bytes))), "") << bytes.substr(0, 40);
  }
  EXPECT_EQ(ToText(OutlineOf("no/such/file.glb")), "");
  EXPECT_EQ(ToText(OutlineOf("/dev/zero")), "");
  EXPECT_EQ(ToText(OutlineOf("builtin:cornell")), "");
}

TEST(SceneOutline, TextKnowsPlurals) {
  EXPECT_EQ(ToText(SceneOutline{1, 0}), "1 texture");
  EXPECT_EQ(ToText(SceneOutline{0, 251}), "251 meshes");
}

}  // namespace
}  // namespace stillray::view::scene_outline_test
