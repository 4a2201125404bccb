// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Real scenes: the importer must find the contents that their documentation lists.
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scene/mesh_tools.h"
#include "stillray/scene.h"

namespace stillray {
namespace {

using ::testing::IsEmpty;

std::string ScenePath(const std::string& name) {
  const char* folder = std::getenv("STILLRAY_TEST_DATA");
  return std::string(folder != nullptr ? folder : STILLRAY_DEFAULT_TEST_DATA) + "/scenes/" + name +
         ".glb";
}

struct Facts {
  const char* name;
  size_t triangles;
  size_t instances;
  size_t meshes;
  size_t textures;
  float yfov_degrees;
  vec3 first_eye;
  vec3 last_eye;
};

void PrintTo(const Facts& facts, std::ostream* out) {
  *out << facts.name;
}

class SharedScene : public ::testing::TestWithParam<Facts> {
 protected:
  void SetUp() override {
    const std::string path = ScenePath(GetParam().name);
    if (!std::filesystem::exists(path)) {
      GTEST_SKIP() << path << " does not exist; STILLRAY_TEST_DATA names the folder with scenes/";
    }
    Result<Scene> loaded = LoadScene(path);
    ASSERT_TRUE(loaded.ok()) << loaded.status().message();
    scene_ = std::move(loaded).value();
  }
  Scene scene_;
};

const Facts kFacts[] = {
    {"kitchen", 1442338, 298, 251, 14, 35.98f, {1.211f, 1.805f, 3.852f}, {1.389f, 1.700f, 3.073f}},
    {"coffee", 235047, 23, 23, 0, 30.98f, {-0.003f, 0.198f, 0.828f}, {0.234f, 0.216f, 0.726f}},
    {"lamp", 309134, 51, 50, 0, 35.0f, {7.756f, 5.068f, -6.643f}, {5.686f, 5.187f, -7.216f}},
};

INSTANTIATE_TEST_SUITE_P(All, SharedScene, ::testing::ValuesIn(kFacts),
                         [](const auto& info) { return std::string(info.param.name); });

TEST_P(SharedScene, HasWhatItsDocumentationSays) {
  const Facts& facts = GetParam();
  EXPECT_EQ(scene_.TriangleCount(), facts.triangles);
  EXPECT_EQ(scene_.instances.size(), facts.instances);
  EXPECT_EQ(scene_.meshes.size(), facts.meshes);
  EXPECT_EQ(scene_.textures.size(), facts.textures);
  EXPECT_THAT(scene_.warnings, IsEmpty());
  EXPECT_EQ(scene_.environment.radiance, vec3(0.0f));
  EXPECT_NEAR(scene_.AnimationLength(), 119.0 / 30.0, 1e-5);
  ASSERT_EQ(scene_.cameras.size(), 1u);
  EXPECT_NEAR(scene_.cameras[0].yfov * 57.2957795f, facts.yfov_degrees, 0.01f);
}

TEST_P(SharedScene, TheCameraMovesAsDocumented) {
  const Facts& facts = GetParam();
  const size_t node = static_cast<size_t>(scene_.cameras[0].node);
  const vec3 first(NodeTransforms(scene_, 0)[node][3]);
  const vec3 last(NodeTransforms(scene_, scene_.AnimationLength())[node][3]);
  EXPECT_LT(glm::length(first - facts.first_eye), 0.002f);
  EXPECT_LT(glm::length(last - facts.last_eye), 0.002f);
  // Keyframe 0 is the static pose.
  Scene still = scene_;
  still.animation.clear();
  const mat4 pose = NodeTransforms(still, 0)[node];
  const mat4 key = NodeTransforms(scene_, 0)[node];
  for (int column = 0; column < 4; ++column) {
    EXPECT_LT(glm::length(vec3(pose[column] - key[column])), 1e-5f) << "column " << column;
  }
}

TEST_P(SharedScene, ComputedTangentsAgreeWithTheFiles) {
  size_t compared = 0;
  size_t agreeing = 0;
  for (const Mesh& mesh : scene_.meshes) {
    const Material& material = scene_.materials[static_cast<size_t>(mesh.material)];
    if (mesh.tangents.empty()) {
      EXPECT_EQ(material.normal_texture.texture, -1) << mesh.name;
      continue;
    }
    Mesh own = mesh;
    own.tangents.clear();
    ComputeTangents(material.normal_texture, &own);
    for (size_t i = 0; i < mesh.indices.size(); ++i) {
      const vec4 a = mesh.tangents[mesh.indices[i]];
      const vec4 b = own.tangents[own.indices[i]];
      ++compared;
      agreeing += glm::dot(vec3(a), vec3(b)) > 0.9f && a.w == b.w ? 1 : 0;
    }
  }
  if (std::string(GetParam().name) == "kitchen") {
    EXPECT_GT(compared, 1000u);
  }
  EXPECT_GE(static_cast<double>(agreeing), 0.95 * static_cast<double>(compared));
}

TEST(SharedSceneDamage, TruncatedAnywhereItIsAnErrorAndNoCrash) {
  const std::string path = ScenePath("coffee");
  if (!std::filesystem::exists(path)) {
    GTEST_SKIP() << path << " does not exist; STILLRAY_TEST_DATA names the folder with scenes/";
  }
  std::ifstream in(path, std::ios::binary);
  const std::vector<char> bytes((std::istreambuf_iterator<char>(in)), {});
  for (size_t part = 0; part < 20; ++part) {
    const Result<Scene> scene = LoadGltfFromMemory(reinterpret_cast<const uint8_t*>(bytes.data()),
                                                   bytes.size() * part / 20, "");
    ASSERT_FALSE(scene.ok()) << part << "/20";
    EXPECT_EQ(scene.status().code(), StatusCode::kBadData) << scene.status().message();
  }
}

}  // namespace
}  // namespace stillray
