// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <numeric>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "stillray/scene.h"

namespace stillray::builtin_test {
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
  ASSERT_EQ(again->meshes.size(), scene_.meshes.size());
  for (size_t i = 0; i < scene_.meshes.size(); ++i) {
    EXPECT_TRUE(again->meshes[i].positions == scene_.meshes[i].positions);
    EXPECT_TRUE(again->meshes[i].normals == scene_.meshes[i].normals);
    EXPECT_TRUE(again->meshes[i].indices == scene_.meshes[i].indices);
  }
}

bool Moves(const Scene& scene, const std::string& name) {
  for (const AnimationChannel& channel : scene.animation) {
    if (scene.nodes[static_cast<size_t>(channel.node)].name == name &&
        std::any_of(channel.values.begin(), channel.values.end(),
                    [&](const vec4& value) { return value != channel.values.front(); })) {
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
  const Scene mirrors = *MakeBuiltinScene("mirrors");
  EXPECT_TRUE(Moves(mirrors, "mirror"));
  EXPECT_TRUE(Moves(mirrors, "crate"));
  const Scene thin = *MakeBuiltinScene("thin");
  for (const char* name : {"cloth", "gate", "wire 1", "wire 4", "tuft 1", "tuft 5"}) {
    EXPECT_TRUE(Moves(thin, name)) << name;
  }
  const Scene faust = *MakeBuiltinScene("faust");
  for (const char* name : {"spinning ball", "orbiting knot", "moving light"}) {
    EXPECT_TRUE(Moves(faust, name)) << name;
  }
  EXPECT_TRUE(Moves(*MakeBuiltinScene("colonnade"), "curtain 2"));
  const Scene car = *MakeBuiltinScene("car");
  EXPECT_TRUE(Moves(car, "car"));
  EXPECT_TRUE(Moves(car, "plate"));
}

/// World positions of all vertices of the meshes called `name`.
std::vector<vec3> Vertices(const Scene& scene, const std::string& name, double seconds) {
  const std::vector<mat4> world = NodeTransforms(scene, seconds);
  std::vector<vec3> out;
  for (const Instance& instance : scene.instances) {
    const Mesh& mesh = scene.meshes[static_cast<size_t>(instance.mesh)];
    if (mesh.name == name) {
      for (const vec3& p : mesh.positions) {
        out.emplace_back(world[static_cast<size_t>(instance.node)] * vec4(p, 1.0f));
      }
    }
  }
  EXPECT_FALSE(out.empty()) << "nothing is called " << name;
  return out;
}

/// Two convex shapes, seen from above, are apart if a direction separates them.
bool Apart(const std::vector<vec3>& a, const std::vector<vec3>& b) {
  for (int angle = 0; angle < 180; ++angle) {
    const vec3 axis(std::cos(angle * 0.0174532925f), 0.0f, std::sin(angle * 0.0174532925f));
    const auto less = [&](vec3 p, vec3 q) { return glm::dot(p, axis) < glm::dot(q, axis); };
    const auto [a_low, a_high] = std::minmax_element(a.begin(), a.end(), less);
    const auto [b_low, b_high] = std::minmax_element(b.begin(), b.end(), less);
    if (less(*a_high, *b_low) || less(*b_high, *a_low)) {
      return true;
    }
  }
  return false;
}

TEST(BuiltinScenes, TheMovingBoxTouchesNothing) {
  const Scene scene = *MakeBuiltinScene("cornell");
  for (int frame = 0; frame < 120; ++frame) {
    const std::vector<vec3> box = Vertices(scene, "moving box", frame / 30.0);
    EXPECT_TRUE(Apart(box, Vertices(scene, "tall box", frame / 30.0))) << "frame " << frame;
    for (const vec3& p : box) {
      EXPECT_LT(std::abs(p.x), 0.2764f) << "frame " << frame;
      EXPECT_GT(p.z, -0.5592f) << "frame " << frame;
    }
  }
}

TEST(BuiltinScenes, TheCrateAndTheMirrorTouchNothing) {
  const Scene scene = *MakeBuiltinScene("mirrors");
  for (int frame = 0; frame < 120; frame += 7) {
    const std::vector<vec3> crate = Vertices(scene, "crate", frame / 30.0);
    for (const char* name : {"chrome ball", "glass ball", "copper drum", "pedestal", "window pane",
                             "mirror pane", "back wall", "left wall"}) {
      EXPECT_TRUE(Apart(crate, Vertices(scene, name, frame / 30.0))) << name << ", frame " << frame;
    }
    const std::vector<vec3> mirror = Vertices(scene, "mirror board", frame / 30.0);
    for (const char* name : {"chrome ball", "copper drum", "back wall", "left wall"}) {
      EXPECT_TRUE(Apart(mirror, Vertices(scene, name, frame / 30.0)))
          << name << ", frame " << frame;
    }
  }
}

// Where the line from the eye to the crate's image behind the mirror passes the mirror's plane.
TEST(BuiltinScenes, TheMirrorShowsTheCrate) {
  const Scene scene = *MakeBuiltinScene("mirrors");
  for (int frame = 0; frame < 120; frame += 7) {
    const double seconds = frame / 30.0;
    const std::vector<vec3> pane = Vertices(scene, "mirror pane", seconds);
    ASSERT_EQ(pane.size(), 4u);
    const vec3 right = pane[1] - pane[0];
    const vec3 up = pane[3] - pane[0];
    const vec3 normal = glm::normalize(glm::cross(right, up));
    const size_t camera = static_cast<size_t>(scene.cameras[0].node);
    const vec3 eye(NodeTransforms(scene, seconds)[camera][3]);
    const std::vector<vec3> crate = Vertices(scene, "crate", seconds);
    const vec3 middle =
        std::accumulate(crate.begin(), crate.end(), vec3(0.0f)) / static_cast<float>(crate.size());
    const float eye_distance = glm::dot(eye - pane[0], normal);
    const float crate_distance = glm::dot(middle - pane[0], normal);
    ASSERT_GT(eye_distance, 0.0f);
    ASSERT_GT(crate_distance, 0.0f);
    const vec3 image = middle - 2.0f * crate_distance * normal;
    const vec3 passed =
        glm::mix(eye, image, eye_distance / (eye_distance + crate_distance)) - pane[0];
    const float u = glm::dot(passed, right) / glm::dot(right, right);
    const float v = glm::dot(passed, up) / glm::dot(up, up);
    EXPECT_TRUE(u > 0.0f && u < 1.0f && v > 0.0f && v < 1.0f)
        << "frame " << frame << ": " << u << ", " << v;
  }
}

const Material& MaterialOf(const Scene& scene, const std::string& mesh_name) {
  const auto mesh = std::find_if(scene.meshes.begin(), scene.meshes.end(),
                                 [&](const Mesh& m) { return m.name == mesh_name; });
  EXPECT_NE(mesh, scene.meshes.end()) << "nothing is called " << mesh_name;
  return scene.materials[static_cast<size_t>(mesh->material)];
}

TEST(BuiltinScenes, MirrorsAreSmoothAndGlassIsThinOrSolid) {
  const Scene scene = *MakeBuiltinScene("mirrors");
  for (const char* name : {"mirror pane", "chrome ball"}) {
    const Material& metal = MaterialOf(scene, name);
    EXPECT_EQ(metal.metallic, 1.0f) << name;
    EXPECT_EQ(metal.roughness, 0.0f) << name;
  }
  EXPECT_EQ(MaterialOf(scene, "copper drum").metallic, 1.0f);
  EXPECT_GT(MaterialOf(scene, "copper drum").roughness, 0.2f);
  const Material& pane = MaterialOf(scene, "window pane");
  EXPECT_EQ(pane.transmission, 1.0f);
  EXPECT_EQ(pane.roughness, 0.0f);
  EXPECT_FALSE(pane.solid);
  const Material& ball = MaterialOf(scene, "glass ball");
  EXPECT_EQ(ball.transmission, 1.0f);
  EXPECT_EQ(ball.roughness, 0.0f);
  EXPECT_TRUE(ball.solid);
  for (const char* name :
       {"floor", "back wall", "left wall", "right wall", "front wall", "pedestal", "crate"}) {
    EXPECT_GE(MaterialOf(scene, name).base_color_texture.texture, 0) << name;
  }
}

TEST(BuiltinScenes, WiresAndBarsAreThin) {
  const Scene scene = *MakeBuiltinScene("thin");
  int seen = 0;
  for (const Mesh& mesh : scene.meshes) {
    if (mesh.name.rfind("bar ", 0) == 0 || mesh.name.rfind("mesh wire ", 0) == 0 ||
        mesh.name.rfind("wire ", 0) == 0) {
      vec3 low = mesh.positions[0];
      vec3 high = mesh.positions[0];
      for (const vec3& p : mesh.positions) {
        low = glm::min(low, p);
        high = glm::max(high, p);
      }
      const vec3 size = high - low;
      EXPECT_LT(std::min({size.x, size.y, size.z}), 0.015f) << mesh.name;
      EXPECT_GT(std::max({size.x, size.y, size.z}), 1.0f) << mesh.name;
      ++seen;
    }
  }
  EXPECT_GT(seen, 20);
  for (const vec3& p : Vertices(scene, "line", 0)) {
    EXPECT_NEAR(glm::length(vec2(p.y - 1.62f, p.z + 0.25f)), 0.004f, 1e-5f);
  }
}

TEST(BuiltinScenes, ClothAndGrassAreSeenFromBothSides) {
  const Scene scene = *MakeBuiltinScene("thin");
  EXPECT_TRUE(MaterialOf(scene, "cloth").double_sided);
  EXPECT_GE(MaterialOf(scene, "cloth").base_color_texture.texture, 0);
  EXPECT_TRUE(MaterialOf(scene, "tuft 1").double_sided);
  const std::vector<vec3> cloth = Vertices(scene, "cloth", 0);
  const auto [back, front] = std::minmax_element(
      cloth.begin(), cloth.end(), [](const vec3& a, const vec3& b) { return a.z < b.z; });
  EXPECT_GT(front->z - back->z, 0.1f) << "the cloth has folds";
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

const Mesh& MeshOf(const Scene& scene, const std::string& name) {
  const auto mesh = std::find_if(scene.meshes.begin(), scene.meshes.end(),
                                 [&](const Mesh& m) { return m.name == name; });
  EXPECT_NE(mesh, scene.meshes.end()) << "nothing is called " << name;
  return *mesh;
}

TEST(BuiltinScenes, FaustHasTwoDetailedObjects) {
  const Scene scene = *MakeBuiltinScene("faust");
  EXPECT_NEAR(static_cast<double>(scene.TriangleCount()), 341000.0, 1000.0);
  EXPECT_GT(MeshOf(scene, "spinning ball").indices.size() / 3, 150000u);
  EXPECT_GT(MeshOf(scene, "orbiting knot").indices.size() / 3, 150000u);
  EXPECT_EQ(MaterialOf(scene, "mirror sphere").metallic, 1.0f);
  EXPECT_EQ(MaterialOf(scene, "mirror sphere").roughness, 0.0f);
  EXPECT_TRUE(MaterialOf(scene, "ceiling light").emits());
  EXPECT_TRUE(MaterialOf(scene, "moving light").emits());
}

/// Lowest and highest coordinates of points.
Aabb BoundsOf(const std::vector<vec3>& points) {
  Aabb bounds;
  for (const vec3& p : points) {
    bounds.min = glm::min(bounds.min, p);
    bounds.max = glm::max(bounds.max, p);
  }
  return bounds;
}

TEST(BuiltinScenes, TheKnotOrbitsWithoutTouching) {
  const Scene scene = *MakeBuiltinScene("faust");
  const std::vector<vec3> sphere = Vertices(scene, "mirror sphere", 0);
  const Aabb sphere_bounds = BoundsOf(sphere);
  const vec3 centre = 0.5f * (sphere_bounds.min + sphere_bounds.max);
  const float radius = 0.5f * (sphere_bounds.max.x - sphere_bounds.min.x);
  for (int frame = 0; frame < 120; frame += 7) {
    const std::vector<vec3> knot = Vertices(scene, "orbiting knot", frame / 30.0);
    for (const vec3& p : knot) {
      ASSERT_GT(glm::length(p - centre), radius) << "frame " << frame;
      ASSERT_GT(p.y, 0.0f) << "frame " << frame;
      ASSERT_LT(std::abs(p.x), 2.6f) << "frame " << frame;
      ASSERT_GT(p.z, -2.6f) << "frame " << frame;
    }
    EXPECT_TRUE(Apart(knot, Vertices(scene, "spinning ball", frame / 30.0))) << "frame " << frame;
    const vec3 camera(
        NodeTransforms(scene, frame / 30.0)[static_cast<size_t>(scene.cameras[0].node)][3]);
    const Aabb bounds = BoundsOf(knot);
    EXPECT_GT(camera.z, bounds.max.z + 0.5f) << "frame " << frame;
  }
}

TEST(BuiltinScenes, TheColonnadeIsLitByTheSunAndTheSky) {
  const Scene scene = *MakeBuiltinScene("colonnade");
  ASSERT_EQ(scene.lights.size(), 1u);
  EXPECT_EQ(scene.lights[0].type, LightType::kDirectional);
  // Lights shine along their node's -z.
  const mat4 sun = NodeTransforms(scene, 0)[static_cast<size_t>(scene.lights[0].node)];
  EXPECT_GT(sun[2].y, 0.7f) << "from above";
  EXPECT_GT(sun[2].x, 0.0f) << "from the right";
  EXPECT_GT(scene.environment.radiance.z, scene.environment.radiance.x) << "the sky is blue";
  EXPECT_TRUE(MaterialOf(scene, "curtain 2").double_sided);
}

// A column has a circular section and an arch a round one: distances from their axes.
TEST(BuiltinScenes, ArchesAreRoundAndStandOnColumns) {
  const Scene scene = *MakeBuiltinScene("colonnade");
  const Mesh& arches = MeshOf(scene, "lower arches");
  size_t round = 0;
  for (size_t i = 0; i < arches.positions.size(); ++i) {
    const vec3 p = arches.positions[i];
    const vec3 n = arches.normals[i];
    if (std::abs(n.z) < 0.5f && n.y > -0.999f) {
      const float bay = std::floor(p.x / 3.0f);
      const vec2 from_centre(p.x - 3.0f * (bay + 0.5f), p.y - 3.6f);
      ASSERT_NEAR(glm::length(from_centre), 1.18f, 1e-4f);
      ASSERT_NEAR(glm::dot(vec2(n), glm::normalize(from_centre)), -1.0f, 1e-4f);
      ++round;
    }
  }
  EXPECT_GT(round, 6u * 2u * 48u);
  const Aabb capital = BoundsOf(Vertices(scene, "abacus", 0));
  EXPECT_NEAR(capital.max.y, 3.6f, 1e-4f);
}

TEST(BuiltinScenes, TheCarStandsOnItsWheelsUnderPanes) {
  const Scene scene = *MakeBuiltinScene("car");
  for (const double seconds : {0.0, 2.0, 4.0}) {
    // On the plate, which is 6 cm high.
    EXPECT_NEAR(BoundsOf(Vertices(scene, "tyre", seconds)).min.y, 0.06f, 1e-3f);
    EXPECT_GT(BoundsOf(Vertices(scene, "body", seconds)).min.y, 0.15f);
  }
  EXPECT_LT(MaterialOf(scene, "body").roughness, 0.1f);
  EXPECT_EQ(MaterialOf(scene, "panes").transmission, 1.0f);
  EXPECT_FALSE(MaterialOf(scene, "panes").solid);
  // As large as a car. Its own axes: the scene turns it.
  const Aabb body = BoundsOf(MeshOf(scene, "body").positions);
  EXPECT_NEAR(body.max.x - body.min.x, 4.2f, 0.2f);
  EXPECT_NEAR(body.max.y, 1.33f, 0.05f);
  EXPECT_NEAR(body.max.z - body.min.z, 1.8f, 0.15f);
  const Aabb panes = BoundsOf(MeshOf(scene, "panes").positions);
  EXPECT_GT(panes.min.y, 0.9f);
  EXPECT_LT(panes.max.y, body.max.y);
}

TEST(BuiltinScenes, AnUnknownNameListsTheKnownOnes) {
  EXPECT_THAT(BuiltinSceneNames(), ElementsAre("cornell", "spheres", "lights", "materials",
                                               "mirrors", "thin", "faust", "colonnade", "car"));
  const Result<Scene> scene = LoadScene("builtin:teapot");
  ASSERT_FALSE(scene.ok());
  EXPECT_EQ(scene.status().code(), StatusCode::kNotFound);
  EXPECT_THAT(scene.status().message(), HasSubstr("teapot"));
  EXPECT_THAT(
      scene.status().message(),
      HasSubstr("cornell, spheres, lights, materials, mirrors, thin, faust, colonnade, car"));
  EXPECT_TRUE(LoadScene("builtin:cornell").ok());
}

}  // namespace
}  // namespace stillray::builtin_test
