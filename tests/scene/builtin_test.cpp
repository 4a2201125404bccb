// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "stillray/scene.h"

namespace stillray {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

class Builtin : public ::testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    Result<Scene> made = MakeBuiltinScene(GetParam());
    ASSERT_TRUE(made.ok()) << made.status().message();
    scene_ = std::move(made).value();
  }
  Scene scene_;
};

std::string NameOf(const ::testing::TestParamInfo<std::string>& info) {
  return info.param;
}

INSTANTIATE_TEST_SUITE_P(All, Builtin, ::testing::ValuesIn(BuiltinSceneNames()), NameOf);

TEST_P(Builtin, IsWhole) {
  EXPECT_EQ(scene_.name, GetParam());
  ASSERT_EQ(scene_.cameras.size(), 1u);
  EXPECT_FALSE(scene_.textures.empty());
  for (const Texture& texture : scene_.textures) {
    EXPECT_EQ(texture.texels.size(),
              static_cast<size_t>(texture.width) * static_cast<size_t>(texture.height) * 4);
    const auto [low, high] = std::minmax_element(texture.texels.begin(), texture.texels.end());
    EXPECT_GT(*high - *low, 50) << texture.name << " shows nothing";
  }
  for (size_t i = 0; i < scene_.nodes.size(); ++i) {
    EXPECT_LT(scene_.nodes[i].parent, static_cast<int>(i));
  }
  for (const Instance& instance : scene_.instances) {
    ASSERT_LT(static_cast<size_t>(instance.mesh), scene_.meshes.size());
    ASSERT_LT(static_cast<size_t>(instance.node), scene_.nodes.size());
  }
}

TEST_P(Builtin, HasSoundMeshes) {
  for (const Mesh& mesh : scene_.meshes) {
    ASSERT_LT(static_cast<size_t>(mesh.material), scene_.materials.size()) << mesh.name;
    ASSERT_EQ(mesh.normals.size(), mesh.positions.size()) << mesh.name;
    ASSERT_EQ(mesh.uv[0].size(), mesh.positions.size()) << mesh.name;
    ASSERT_EQ(mesh.indices.size() % 3, 0u) << mesh.name;
    for (size_t i = 0; i < mesh.indices.size(); i += 3) {
      const uint32_t* c = &mesh.indices[i];
      ASSERT_LT(std::max({c[0], c[1], c[2]}), mesh.positions.size()) << mesh.name;
      const vec3 side = glm::cross(mesh.positions[c[1]] - mesh.positions[c[0]],
                                   mesh.positions[c[2]] - mesh.positions[c[0]]);
      // The front of every triangle is where its normals point, within the bend of a sphere.
      ASSERT_GT(glm::dot(glm::normalize(side), mesh.normals[c[0]]), 0.9f)
          << mesh.name << ", triangle " << i / 3;
    }
    for (const vec3& normal : mesh.normals) {
      ASSERT_NEAR(glm::length(normal), 1.0f, 1e-5f) << mesh.name;
    }
  }
}

TEST_P(Builtin, MovesForFourSecondsWithoutJumps) {
  EXPECT_NEAR(scene_.AnimationLength(), 119.0 / 30.0, 1e-6);
  const int camera = scene_.cameras[0].node;
  const double diagonal = glm::length(SceneBounds(scene_, 0).max - SceneBounds(scene_, 0).min);
  double path = 0;
  for (int frame = 1; frame < 120; ++frame) {
    const std::vector<mat4> before = NodeTransforms(scene_, (frame - 1) / 30.0);
    const std::vector<mat4> now = NodeTransforms(scene_, frame / 30.0);
    for (size_t i = 0; i < now.size(); ++i) {
      EXPECT_LT(glm::length(vec3(now[i][3]) - vec3(before[i][3])), 0.02 * diagonal);
    }
    const size_t c = static_cast<size_t>(camera);
    path += glm::length(vec3(now[c][3]) - vec3(before[c][3]));
    EXPECT_NEAR(glm::length(vec3(now[c][2])), 1.0f, 1e-5f);
  }
  const vec3 eye(NodeTransforms(scene_, 0)[static_cast<size_t>(camera)][3]);
  EXPECT_GT(path, 0.02 * glm::length(eye)) << "all scenes stand about the origin";
}

TEST_P(Builtin, TheCameraSeesTheMiddleOfTheScene) {
  for (const double seconds : {0.0, 2.0, 4.0}) {
    const mat4 camera =
        NodeTransforms(scene_, seconds)[static_cast<size_t>(scene_.cameras[0].node)];
    const Aabb bounds = SceneBounds(scene_, seconds);
    const vec3 centre = 0.5f * (bounds.min + bounds.max);
    const vec3 to_centre = glm::normalize(centre - vec3(camera[3]));
    EXPECT_GT(glm::dot(to_centre, -vec3(camera[2])), 0.8f) << "at " << seconds << " s";
    EXPECT_GT(camera[1].y, 0.8f) << "the picture stands upright";
  }
}

TEST_P(Builtin, IsTheSameEveryTime) {
  const Result<Scene> again = MakeBuiltinScene(GetParam());
  ASSERT_TRUE(again.ok());
  ASSERT_EQ(again->textures.size(), scene_.textures.size());
  for (size_t i = 0; i < scene_.textures.size(); ++i) {
    EXPECT_TRUE(again->textures[i].texels == scene_.textures[i].texels);
  }
}

bool Moves(const Scene& scene, const std::string& name) {
  for (const AnimationChannel& channel : scene.animation) {
    if (scene.nodes[static_cast<size_t>(channel.node)].name == name &&
        channel.values.front() != channel.values.back()) {
      return true;
    }
  }
  return false;
}

TEST(BuiltinScenes, SomethingMovesBesidesTheCamera) {
  EXPECT_TRUE(Moves(*MakeBuiltinScene("cornell"), "moving box"));
  const Scene lights = *MakeBuiltinScene("lights");
  EXPECT_TRUE(Moves(lights, "lamp"));
  EXPECT_TRUE(Moves(lights, "rail"));
}

TEST(BuiltinScenes, TheMovingBoxTouchesNothing) {
  const Scene scene = *MakeBuiltinScene("cornell");
  const auto corners = [&](const char* name, double seconds) {
    std::vector<vec2> out;
    for (const Instance& instance : scene.instances) {
      const Mesh& mesh = scene.meshes[static_cast<size_t>(instance.mesh)];
      if (mesh.name == name) {
        const mat4 world = NodeTransforms(scene, seconds)[static_cast<size_t>(instance.node)];
        for (const vec3& p : mesh.positions) {
          const vec3 q(world * vec4(p, 1.0f));
          out.emplace_back(q.x, q.z);
        }
      }
    }
    return out;
  };
  // Two convex shapes are apart if the direction between their middles separates them.
  for (int frame = 0; frame < 120; ++frame) {
    const std::vector<vec2> box = corners("moving box", frame / 30.0);
    const std::vector<vec2> tall = corners("tall box", frame / 30.0);
    bool apart = false;
    for (int angle = 0; angle < 180; ++angle) {
      const vec2 axis(std::cos(angle * 0.0174532925f), std::sin(angle * 0.0174532925f));
      const auto less = [&](vec2 a, vec2 b) { return glm::dot(a, axis) < glm::dot(b, axis); };
      const auto [box_low, box_high] = std::minmax_element(box.begin(), box.end(), less);
      const auto [tall_low, tall_high] = std::minmax_element(tall.begin(), tall.end(), less);
      apart = apart || glm::dot(*box_high, axis) < glm::dot(*tall_low, axis) ||
              glm::dot(*tall_high, axis) < glm::dot(*box_low, axis);
    }
    EXPECT_TRUE(apart) << "frame " << frame;
    for (const vec2& p : box) {
      EXPECT_LT(std::abs(p.x), 0.2764f) << "frame " << frame;
      EXPECT_GT(p.y, -0.5592f) << "frame " << frame;
    }
  }
}

TEST(BuiltinScenes, TheSkyIsBrightAboveAndHasASun) {
  const Scene scene = *MakeBuiltinScene("spheres");
  const Image3& map = scene.environment.map;
  ASSERT_EQ(map.width(), 512);
  ASSERT_EQ(map.height(), 256);
  EXPECT_GT(map[2](0, 2), map[2](0, 250));
  float brightest = 0;
  for (int y = 0; y < map.height(); ++y) {
    for (int x = 0; x < map.width(); ++x) {
      brightest = std::max(brightest, map[0](x, y));
      ASSERT_GE(map[0](x, y), 0.0f);
    }
  }
  EXPECT_GT(brightest, 10.0f);
}

TEST(BuiltinScenes, AnUnknownNameListsTheKnownOnes) {
  EXPECT_THAT(BuiltinSceneNames(), ElementsAre("cornell", "spheres", "lights"));
  const Result<Scene> scene = LoadScene("builtin:teapot");
  ASSERT_FALSE(scene.ok());
  EXPECT_EQ(scene.status().code(), StatusCode::kNotFound);
  EXPECT_THAT(scene.status().message(), HasSubstr("teapot"));
  EXPECT_THAT(scene.status().message(), HasSubstr("cornell, spheres, lights"));
  EXPECT_TRUE(LoadScene("builtin:cornell").ok());
}

}  // namespace
}  // namespace stillray
