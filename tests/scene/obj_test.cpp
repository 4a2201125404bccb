// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <filesystem>
#include <map>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scene/gltf_builder.h"
#include "scene/obj_import.h"
#include "scene/test_pictures.h"

namespace stillray::obj_test {
namespace {

using test::TemporaryFolder;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

const char* const kTriangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

class Obj : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!ReadsObj()) {
      GTEST_SKIP() << "this build has no tinyobjloader";
    }
  }

  Result<Scene> Import(const std::string& text) const {
    return ImportObj(
        std::span<const uint8_t>(reinterpret_cast<const uint8_t*>(text.data()), text.size()),
        [&](const std::string& name) -> Result<std::vector<uint8_t>> {
          const auto file = files_.find(name);
          if (file == files_.end()) {
            return Status::NotFound(name + ": no such file");
          }
          return file->second;
        },
        {});
  }

  Scene Load(const std::string& text) const {
    Result<Scene> scene = Import(text);
    EXPECT_TRUE(scene.ok()) << scene.status().message();
    return scene.ok() ? std::move(scene).value() : Scene();
  }

  /// The only material of a triangle with this MTL body.
  Material LoadMaterial(const std::string& mtl) {
    AddText("m.mtl", "newmtl m\n" + mtl);
    scene_ =
        Load("mtllib m.mtl\nvt 0.25 0.75\nusemtl m\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1/1 2/1 3/1\n");
    return scene_.materials.empty() ? Material() : scene_.materials[0];
  }

  void ExpectError(const std::string& text, const std::string& part) const {
    const Result<Scene> scene = Import(text);
    ASSERT_FALSE(scene.ok()) << text;
    EXPECT_EQ(scene.status().code(), StatusCode::kBadData);
    EXPECT_THAT(scene.status().message(), HasSubstr(part));
    EXPECT_THAT(scene.status().message(), Not(HasSubstr("\n")));
  }

  void AddText(const std::string& name, const std::string& text) {
    files_[name] = std::vector<uint8_t>(text.begin(), text.end());
  }
  void AddPicture(const std::string& name, const std::vector<uint8_t>& rgba, int width,
                  int height) {
    files_[name] = test::EncodePng(rgba, width, height);
  }

  std::map<std::string, std::vector<uint8_t>> files_;
  Scene scene_;
};

TEST_F(Obj, ATriangleGetsNormalMaterialCameraAndLight) {
  const Scene scene = Load(kTriangle);
  ASSERT_EQ(scene.meshes.size(), 1u);
  EXPECT_THAT(scene.meshes[0].positions, ElementsAre(vec3(0, 0, 0), vec3(1, 0, 0), vec3(0, 1, 0)));
  EXPECT_THAT(scene.meshes[0].normals, ElementsAre(vec3(0, 0, 1), vec3(0, 0, 1), vec3(0, 0, 1)));
  EXPECT_THAT(scene.meshes[0].indices, ElementsAre(0, 1, 2));
  EXPECT_TRUE(scene.meshes[0].uv[0].empty());
  const Material& material = scene.materials.at(0);
  EXPECT_EQ(material.base_color, vec4(0.8f, 0.8f, 0.8f, 1.0f));
  EXPECT_EQ(material.metallic, 0.0f);
  EXPECT_TRUE(material.double_sided);
  EXPECT_EQ(scene.cameras.size(), 1u);
  EXPECT_EQ(scene.environment.radiance, vec3(1.0f));
  EXPECT_THAT(scene.warnings,
              ElementsAre(HasSubstr("no perspective camera"), HasSubstr("no light")));
}

TEST_F(Obj, NegativeIndicesCountFromTheLast) {
  const Scene scene = Load("v 9 9 9\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\nv 5 5 5\n");
  EXPECT_THAT(scene.meshes.at(0).positions,
              ElementsAre(vec3(0, 0, 0), vec3(1, 0, 0), vec3(0, 1, 0)));
}

TEST_F(Obj, IndicesMayPointAhead) {
  EXPECT_EQ(Load("f 1 2 3\nv 0 0 0\nv 1 0 0\nv 0 1 0\n").TriangleCount(), 1u);
}

double Area(const Mesh& mesh) {
  double area = 0;
  for (size_t i = 0; i < mesh.indices.size(); i += 3) {
    const vec3 a = mesh.positions[mesh.indices[i]];
    area +=
        0.5 * static_cast<double>(glm::length(glm::cross(mesh.positions[mesh.indices[i + 1]] - a,
                                                         mesh.positions[mesh.indices[i + 2]] - a)));
  }
  return area;
}

TEST_F(Obj, ConcavePolygonsKeepTheirArea) {
  // An L of area 3: as a fan it would cover 4.
  const Scene scene = Load("v 0 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\nv 1 2 0\nv 0 2 0\nf 2 3 4 5 6 1\n");
  EXPECT_EQ(scene.TriangleCount(), 4u);
  EXPECT_NEAR(Area(scene.meshes.at(0)), 3.0, 1e-6);
}

TEST_F(Obj, LargePolygonsAreDividedAsFans) {
  std::string text;
  std::string face = "f";
  for (int i = 0; i < 300; ++i) {
    const double angle = 2.0 * 3.14159265358979 * i / 300;
    text += "v " + std::to_string(std::cos(angle)) + " " + std::to_string(std::sin(angle)) + " 0\n";
    face += " " + std::to_string(i + 1);
  }
  const Scene scene = Load(text + face + "\n");
  EXPECT_EQ(scene.TriangleCount(), 298u);
  EXPECT_NEAR(Area(scene.meshes.at(0)), 3.14159, 1e-3);
  EXPECT_THAT(scene.warnings, Contains(HasSubstr("as if they were convex")));
}

/// A cube of side 2 about the origin.
std::string Cube() {
  return "v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1\n"
         "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 3 4 8 7\nf 2 3 7 6\nf 1 5 8 4\n";
}

TEST_F(Obj, SmoothingGroupsAverageByAngle) {
  // All three faces of a corner count equally, however each was divided into triangles.
  const Scene scene = Load("s 1\n" + Cube());
  const Mesh& mesh = scene.meshes.at(0);
  EXPECT_EQ(mesh.positions.size(), 8u);
  for (size_t i = 0; i < mesh.positions.size(); ++i) {
    EXPECT_NEAR(glm::dot(mesh.normals[i], mesh.positions[i]), std::sqrt(3.0f), 1e-5f);
  }
}

TEST_F(Obj, WithoutSmoothingFacesAreFlat) {
  for (const char* off : {"", "s off\n", "s 0\n"}) {
    const Scene scene = Load(off + Cube());
    const Mesh& mesh = scene.meshes.at(0);
    EXPECT_EQ(mesh.positions.size(), 36u);
    for (size_t i = 0; i < mesh.positions.size(); ++i) {
      EXPECT_NEAR(glm::dot(mesh.normals[i], mesh.positions[i]), 1.0f, 1e-6f);
    }
  }
}

TEST_F(Obj, EdgesBetweenSmoothingGroupsAreSharp) {
  // A roof of two rectangles; the group number 4000000000 does not fit into 32 signed bits.
  const std::string points = "v 0 0 0\nv 0 0 1\nv 1 1 1\nv 1 1 0\nv 2 0 1\nv 2 0 0\n";
  const Scene smooth = Load(points + "s 4000000000\nf 1 2 3 4\nf 4 3 5 6\n");
  EXPECT_EQ(smooth.meshes.at(0).positions.size(), 6u);
  const Scene sharp = Load(points + "s 4000000000\nf 1 2 3 4\ns 2\nf 4 3 5 6\n");
  EXPECT_EQ(sharp.meshes.at(0).positions.size(), 8u);
  for (size_t i = 0; i < sharp.meshes[0].normals.size(); ++i) {
    EXPECT_NEAR(std::abs(sharp.meshes[0].normals[i].x), std::sqrt(0.5f), 1e-6f);
  }
  int upright = 0;
  for (const vec3& normal : smooth.meshes[0].normals) {
    upright += std::abs(normal.y) > 0.999f ? 1 : 0;
  }
  EXPECT_EQ(upright, 2) << "the ridge";
}

TEST_F(Obj, GivenNormalsAreNormalisedAndZerosReplaced) {
  const Scene scene = Load("v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 3 4\nvn 0 0 0\nf 1//1 2//1 3//2\n");
  EXPECT_NEAR(scene.meshes.at(0).normals[0].y, 0.6f, 1e-6f);
  EXPECT_EQ(scene.meshes[0].normals[2], vec3(0, 0, 1));
  EXPECT_THAT(scene.warnings, Contains(HasSubstr("1 normals without a direction")));
}

TEST_F(Obj, GroupsAndMaterialsDivideTheFaces) {
  AddText("two names.mtl", "newmtl red paint\nKd 1 0 0\nnewmtl blue\nKd 0 0 1\n");
  const Scene scene = Load(
      "mtllib two names.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"
      "o lamp\nusemtl red paint\nf 1 2 3\nusemtl blue\nf 1 2 4\nf 2 3 4\n"
      "g foot # 1\nf 1 3 4\n");
  ASSERT_EQ(scene.meshes.size(), 3u);
  EXPECT_EQ(scene.meshes[0].name, "lamp");
  EXPECT_EQ(scene.meshes[0].indices.size(), 3u);
  EXPECT_EQ(scene.meshes[1].name, "lamp");
  EXPECT_EQ(scene.meshes[1].indices.size(), 6u);
  EXPECT_EQ(scene.meshes[2].name, "foot # 1");
  EXPECT_EQ(scene.materials[static_cast<size_t>(scene.meshes[0].material)].base_color,
            vec4(1, 0, 0, 1));
  EXPECT_EQ(scene.materials[static_cast<size_t>(scene.meshes[2].material)].base_color,
            vec4(0, 0, 1, 1));
  EXPECT_EQ(scene.instances[0].node, scene.instances[1].node);
  EXPECT_NE(scene.instances[0].node, scene.instances[2].node);
}

TEST_F(Obj, TextureCoordinatesPointUp) {
  const Scene scene = Load("v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0.25 0.75\nf 1/1 2/1 3/1\n");
  EXPECT_EQ(scene.meshes.at(0).uv[0].at(0), vec2(0.25f, 0.25f));
}

TEST_F(Obj, ColoursBehindPositionsAreSrgb) {
  const Scene scene = Load("v 0 0 0 1 0.5 0\nv 1 0 0 1 0.5 0\nv 0 1 0 1 0.5 2\nf 1 2 3\n");
  ASSERT_EQ(scene.meshes.at(0).colors.size(), 3u);
  EXPECT_NEAR(scene.meshes[0].colors[0].y, 0.21404f, 1e-4f);
  EXPECT_EQ(scene.meshes[0].colors[2].z, 1.0f) << "clamped";
  EXPECT_TRUE(Load(kTriangle).meshes[0].colors.empty());
}

TEST_F(Obj, LinesMayContinueAndEndInAnyWay) {
  EXPECT_EQ(Load("v 0 0 0\r\nv 1 0 \\\r\n 0\r\n v +0 1e0 .0 # up\r\nf 1 \\\r\n2 3").TriangleCount(),
            1u);
}

TEST_F(Obj, PhongExponentsBecomeRoughness) {
  // alpha = roughness^2, and the exponent is 2 / alpha^2 - 2 (Walter et al. 2007).
  for (const double roughness : {0.1, 0.3, 0.7}) {
    const double alpha = roughness * roughness;
    const Material material = LoadMaterial("Kd 0.5 0.5 0.5\nKs 1 1 1\nNs " +
                                           std::to_string(2.0 / (alpha * alpha) - 2.0) + "\n");
    EXPECT_NEAR(material.roughness, roughness, 1e-4);
    EXPECT_EQ(material.metallic, 0.0f);
  }
  EXPECT_EQ(LoadMaterial("Kd 0.5 0.5 0.5\nNs 100\n").roughness, 1.0f) << "without Ks";
  EXPECT_EQ(LoadMaterial("Ks 1 1 1\nNs 100\nillum 1\n").roughness, 1.0f) << "illum 1";
  EXPECT_EQ(LoadMaterial("Ks 1 1 1\nNs 100\nPr 0.25\nPm 0.75\n").roughness, 0.25f);
  EXPECT_EQ(LoadMaterial("Ks 1 1 1\nNs 100\nPr 0.25\nPm 0.75\n").metallic, 0.75f);
}

TEST_F(Obj, BlackDiffuseUnderSpecularIsMetal) {
  const Material metal = LoadMaterial("Kd 0 0 0\nKs 0.9 0.6 0.3\nNs 1000\n");
  EXPECT_EQ(metal.metallic, 1.0f);
  EXPECT_EQ(metal.base_color, vec4(0.9f, 0.6f, 0.3f, 1.0f));
  EXPECT_EQ(LoadMaterial("Kd 0 0 0\n").metallic, 0.0f) << "black";
}

TEST_F(Obj, MaterialsWithoutColourAreGrey) {
  EXPECT_EQ(LoadMaterial("Ns 10\n").base_color, vec4(0.8f, 0.8f, 0.8f, 1.0f));
  AddPicture("wood.png", test::TestTexels(2, 2), 2, 2);
  EXPECT_EQ(LoadMaterial("map_Kd wood.png\n").base_color, vec4(1.0f));
}

TEST_F(Obj, EmissionAndOpacity) {
  const Material lamp = LoadMaterial("Kd 0 0 0\nKe 10 8 6\nd 0.25\n");
  EXPECT_EQ(lamp.emission, vec3(10, 8, 6));
  EXPECT_EQ(lamp.base_color.w, 0.25f);
  EXPECT_EQ(lamp.alpha_mode, AlphaMode::kBlend);
  EXPECT_THAT(scene_.warnings, Not(Contains(HasSubstr("no light"))));
  EXPECT_EQ(LoadMaterial("Tr 0.75\n").base_color.w, 0.25f);
}

TEST_F(Obj, RefractionIsSolidGlass) {
  const Material glass =
      LoadMaterial("Kd 0 0 0\nKs 1 1 1\nNs 1e9\nNi 1.33\nTf 0.5 1 0.5\nillum 7\n");
  EXPECT_EQ(glass.transmission, 1.0f);
  EXPECT_TRUE(glass.solid);
  EXPECT_FALSE(glass.double_sided);
  EXPECT_EQ(glass.ior, 1.33f);
  EXPECT_EQ(glass.base_color, vec4(0.5f, 1.0f, 0.5f, 1.0f));
  EXPECT_LT(glass.roughness, 0.01f);
  EXPECT_EQ(LoadMaterial("Ni 1\nillum 4\nTf 1 1 1\n").transmission, 0.0f)
      << "what exporters write for opaque materials";
}

TEST_F(Obj, OpacityMapsJoinTheColour) {
  AddPicture("c.png", {10, 20, 30, 0, 40, 50, 60, 0}, 2, 1);
  AddPicture("a.png", {0, 0, 0, 255, 255, 255, 255, 255, 90, 90, 90, 255, 30, 60, 90, 255}, 4, 1);
  Material material = LoadMaterial("map_Kd c.png\nmap_d a.png\n");
  ASSERT_EQ(scene_.textures.size(), 1u);
  EXPECT_EQ(scene_.textures[0].width, 4);
  EXPECT_THAT(scene_.textures[0].texels,
              ElementsAre(10, 20, 30, 0, 10, 20, 30, 255, 40, 50, 60, 90, 40, 50, 60, 60));
  EXPECT_EQ(material.alpha_mode, AlphaMode::kBlend);
  // The same picture: its own alpha.
  material = LoadMaterial("map_Kd c.png\nmap_d c.png\n");
  EXPECT_THAT(scene_.textures.at(0).texels, ElementsAre(10, 20, 30, 0, 40, 50, 60, 0));
  // Without map_d the alpha of the colour is no opacity.
  material = LoadMaterial("map_Kd c.png\n");
  EXPECT_THAT(scene_.textures.at(0).texels, ElementsAre(10, 20, 30, 255, 40, 50, 60, 255));
  EXPECT_EQ(material.alpha_mode, AlphaMode::kOpaque);
}

TEST_F(Obj, RoughnessAndMetalShareATexture) {
  AddPicture("r.png", {11, 0, 0, 255}, 1, 1);
  AddPicture("m.png", {22, 0, 0, 255}, 1, 1);
  Material material = LoadMaterial("map_Pr r.png\nmap_Pm m.png\n");
  EXPECT_THAT(scene_.textures.at(0).texels, ElementsAre(255, 11, 22, 255));
  EXPECT_EQ(material.metallic_roughness_texture.texture, 0);
  EXPECT_EQ(material.roughness, 1.0f);
  EXPECT_EQ(material.metallic, 1.0f);
  material = LoadMaterial("Pr 0.5\nmap_Pr r.png\n");
  EXPECT_EQ(material.roughness, 0.5f);
  EXPECT_EQ(material.metallic, 0.0f);
}

TEST_F(Obj, NormalMapsAreUsedAndHeightsAreNot) {
  AddPicture("n.png", {128, 128, 255, 255, 200, 128, 220, 255}, 2, 1);
  AddPicture("h.png", {128, 128, 128, 255, 200, 200, 200, 255}, 2, 1);
  EXPECT_EQ(LoadMaterial("norm n.png\n").normal_texture.texture, 0);
  EXPECT_EQ(scene_.meshes.at(0).tangents.size(), 3u);
  const Material bumped = LoadMaterial("map_bump -bm 0.5 n.png\n");
  EXPECT_EQ(bumped.normal_texture.texture, 0);
  EXPECT_EQ(bumped.normal_scale, 0.5f);
  EXPECT_LT(LoadMaterial("bump h.png\n").normal_texture.texture, 0);
  EXPECT_THAT(scene_.warnings, Contains(HasSubstr("bump 'h.png' is left out: it holds heights")));
}

TEST_F(Obj, OptionsOfMapsScaleAndShift) {
  AddPicture("c.png", test::TestTexels(2, 2), 2, 2);
  const Material material = LoadMaterial("map_Kd -s 2 3 1 -o 0.1 0.2 0 -clamp on c.png\n");
  // OBJ: s * (0.25, 0.75) + o = (0.6, 2.45), v up; the mesh holds (0.25, 0.25), v down.
  const vec3 at = material.base_color_texture.transform * vec3(scene_.meshes.at(0).uv[0][0], 1.0f);
  EXPECT_NEAR(at.x, 0.6f, 1e-6f);
  EXPECT_NEAR(at.y, 1.0f - 2.45f, 1e-6f);
  EXPECT_EQ(scene_.textures.at(0).wrap_u, Wrap::kClamp);
}

// Two pictures of a few hundred bytes: 1 GiB as one texture.
TEST_F(Obj, SmallPicturesCannotMakeHugeTextures) {
  AddPicture("wide.png", std::vector<uint8_t>(4 * 16384, 9), 16384, 1);
  AddPicture("high.png", std::vector<uint8_t>(4 * 16384, 9), 1, 16384);
  const Material material = LoadMaterial("map_Kd wide.png\nmap_d high.png\n");
  EXPECT_TRUE(scene_.textures.empty());
  EXPECT_LT(material.base_color_texture.texture, 0);
  EXPECT_THAT(scene_.warnings, Contains(HasSubstr("a texture is left out: 16384x16384 texels")));
}

TEST_F(Obj, MaterialsShareTextures) {
  AddPicture("c.png", test::TestTexels(2, 2), 2, 2);
  AddText("m.mtl", "newmtl a\nmap_Kd c.png\nnewmtl b\nmap_Kd c.png\nmap_Ke c.png\n");
  const std::string face = "f 1/1 2/1 3/1\n";
  const Scene scene = Load("mtllib m.mtl\nvt 0 0\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\n" + face +
                           "usemtl b\n" + face);
  ASSERT_EQ(scene.materials.size(), 2u);
  EXPECT_EQ(scene.materials[0].base_color_texture.texture,
            scene.materials[1].base_color_texture.texture);
  EXPECT_EQ(scene.textures.size(), 2u) << "colour and light";
}

TEST_F(Obj, WhatIsMissingIsNamed) {
  const Scene scene = Load("mtllib lost.mtl\nusemtl gone\n" + std::string(kTriangle));
  EXPECT_THAT(scene.warnings, Contains(HasSubstr("mtllib 'lost.mtl' is left out")));
  EXPECT_THAT(scene.warnings, Contains(HasSubstr("material 'gone' is in no material library")));
  EXPECT_EQ(scene.materials.at(0).name, "gone");
  LoadMaterial("map_Kd lost.png\nmap_Ke lost.png\n");
  EXPECT_THAT(scene_.warnings,
              Contains(HasSubstr("map_Kd 'lost.png' is left out: lost.png: no such")));
  EXPECT_FALSE(scene_.materials[0].emits()) << "the lamp's picture is missing";
  AddText("bad.png", "<html>");
  EXPECT_LT(LoadMaterial("map_Kd bad.png\n").base_color_texture.texture, 0);
  EXPECT_THAT(scene_.warnings, Contains(HasSubstr("map_Kd 'bad.png' is left out: ")));
  LoadMaterial("map_Kd lost.png\ndisp d.png\nPc 1\nmap_Ks s.png\n");
  EXPECT_THAT(scene_.warnings, Contains(HasSubstr("displacement 'd.png'")));
  EXPECT_THAT(scene_.warnings, Contains(HasSubstr("clear coat")));
  EXPECT_THAT(scene_.warnings, Contains(HasSubstr("map_Ks")));
}

TEST_F(Obj, UvsThatAreMissingAreAdded) {
  AddPicture("c.png", test::TestTexels(2, 2), 2, 2);
  AddText("m.mtl", "newmtl m\nmap_Kd c.png\n");
  const Scene scene = Load("mtllib m.mtl\nusemtl m\n" + std::string(kTriangle));
  EXPECT_EQ(scene.meshes.at(0).uv[0].size(), 3u);
  EXPECT_THAT(scene.warnings, Contains(HasSubstr("has no texture coordinates")));
}

TEST_F(Obj, DamageIsNamedWithItsLine) {
  const std::string points = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  ExpectError("", "the file is empty");
  ExpectError(points, "no faces in 3 lines");
  ExpectError("hello\nworld\n", "no faces");
  ExpectError(points + "f 1 2 4\n", "line 4: vertex 4 is out of range, there are 3");
  ExpectError(points + "f 1 2 -4\n", "line 4: vertex -4 is out of range, there are 3");
  ExpectError(points + "f 0 1 2\n", "line 4: vertex 0 is out of range");
  ExpectError(points + "f 1 2 99999999999999999999\n", "line 4: vertex 99999999999999999999");
  ExpectError(points + "f 1 2 4000000000\n", "vertex 4000000000 is out of range");
  ExpectError(points + "vt 0 0\nf 1/1 2/2 3/1\n", "line 5: texture coordinate 2 is out of range");
  ExpectError(points + "f 1//1 2//1 3//1\n", "line 4: normal 1 is out of range, there are 0");
  ExpectError(points + "f 1 2\n", "line 4: a face needs 3 corners, found 2");
  ExpectError(points + "f 1 2 x\n", "line 4: 'x' is no corner");
  ExpectError(points + "f 1 2 3/1/1/1\n", "'3/1/1/1' is no corner");
  ExpectError("v 0 nan 0\n" + points + "f 1 2 3\n", "line 1: v 2: 'nan' is not finite");
  ExpectError("v 0 0 1e400\n" + points + "f 1 2 3\n", "line 1: v 3: '1e400' is not finite");
  ExpectError("v 0 0 1e39\n" + points + "f 1 2 3\n", "line 1: v 3: '1e39' is beyond");
  ExpectError("v 0 zero 0\n" + points + "f 1 2 3\n", "line 1: v 2: 'zero' is no number");
  ExpectError(points + "f 1 2 3\nv 1 2\n", "line 5: v needs 3 numbers, found 2");
  ExpectError(points + std::string("f 1 2\0 3\n", 9), "line 4: byte 0x00 is not text");
  ExpectError("v 1 1 1\nv 1 1 1\nv 1 1 1\nf 1 2 3\n", "the scene has no triangles");
}

TEST_F(Obj, EveryTruncationLoadsOrFails) {
  AddText("m.mtl", "newmtl m\nKd 1 0 0\nmap_Kd x.png\n");
  const std::string text =
      "mtllib m.mtl\nusemtl m\ns 1\nvt 0 0\nvn 0 0 1\n" + Cube() + "f 1/1/1 2/1/1 3/1/1\n";
  for (size_t length = 0; length < text.size(); ++length) {
    const Result<Scene> scene = Import(text.substr(0, length));
    EXPECT_TRUE(scene.ok() || !scene.status().message().empty());
  }
}

TEST_F(Obj, DamagedMaterialsLoad) {
  for (const char* mtl :
       {"Kd\n", "Kd x y z\n", "Ns -5\nNi 99999\n", "d nan\n", "Ke 1e99 1 1\n", "Pr 7\nPm -3\n",
        "map_Kd\n", "map_Kd -s\n", "norm -bm x\n", "illum 99\n"}) {
    const Material m = LoadMaterial(mtl);
    EXPECT_TRUE(m.roughness >= 0.0f && m.roughness <= 1.0f) << mtl;
    EXPECT_TRUE(m.metallic >= 0.0f && m.metallic <= 1.0f) << mtl;
    EXPECT_TRUE(m.ior >= 1.0f && m.ior <= 10.0f) << mtl;
    EXPECT_TRUE(std::isfinite(m.emission.x)) << mtl;
    EXPECT_TRUE(m.base_color.w >= 0.0f && m.base_color.w <= 1.0f) << mtl;
  }
}

TEST_F(Obj, TrianglesThatCannotBeHitAreLeftOut) {
  const Scene scene = Load(std::string(kTriangle) + "f 1 1 2\nv 1e30 0 0\nf 1 2 4\n");
  EXPECT_EQ(scene.TriangleCount(), 1u);
  EXPECT_THAT(scene.warnings, Contains(HasSubstr("1 triangles without area")));
  EXPECT_THAT(scene.warnings, Contains(HasSubstr("1 triangles with positions beyond")));
}

TEST_F(Obj, FilesStayInTheirFolder) {
  const TemporaryFolder folder;
  folder.Write("m.mtl", "newmtl m\nmap_Kd ..\\secret.png\nmap_Ke /etc/passwd\nnorm C:\\n.png\n");
  const std::string path =
      folder.Write("a.OBJ", "mtllib m.mtl\nusemtl m\n" + std::string(kTriangle));
  const Result<Scene> scene = LoadScene(path);
  ASSERT_TRUE(scene.ok()) << scene.status().message();
  EXPECT_EQ(scene->name, "a");
  int outside = 0;
  for (const std::string& warning : scene->warnings) {
    outside += warning.find("lies outside the folder") != std::string::npos ? 1 : 0;
  }
  EXPECT_EQ(outside, 3);
}

TEST_F(Obj, PicturesBelowTheFolderLoadByWindowsPaths) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder.path() + "/maps");
  folder.Write("maps/a b.png", test::EncodePng(test::TestTexels(2, 2), 2, 2));
  folder.Write("m.mtl", "newmtl m\r\nmap_Kd maps\\a b.png\r\n");
  const std::string text = "mtllib ./m.mtl\r\nusemtl m\r\n" + std::string(kTriangle);
  const std::string path = folder.Write("s.obj", text);
  const Result<Scene> scene = LoadScene(path);
  ASSERT_TRUE(scene.ok()) << scene.status().message();
  EXPECT_EQ(scene->textures.size(), 1u);
  const uint64_t checksum = scene->checksum;
  EXPECT_NE(checksum, 0u);
  folder.Write("m.mtl", "newmtl m\r\nmap_Kd maps\\a b.png\r\nKd 1 1 1\r\n");
  EXPECT_NE(LoadScene(path)->checksum, checksum);
  const Result<Scene> lost = LoadScene(folder.path() + "/lost.obj");
  EXPECT_EQ(lost.status().code(), StatusCode::kNotFound);
  folder.Write("bad.obj", "v 0 0\n");
  EXPECT_THAT(LoadScene(folder.path() + "/bad.obj").status().message(),
              HasSubstr("bad.obj: line 1: v needs 3 numbers"));
}

TEST_F(Obj, LoadingCanBeStopped) {
  const std::string text = "usemtl a\n" + std::string(kTriangle);
  int calls = 0;
  const Result<Scene> scene = ImportObj(
      std::span<const uint8_t>(reinterpret_cast<const uint8_t*>(text.data()), text.size()),
      [](const std::string&) -> Result<std::vector<uint8_t>> { return Status::NotFound("none"); },
      [&] { return ++calls < 2; });
  EXPECT_EQ(scene.status().code(), StatusCode::kCancelled);
}

TEST(ObjAbsent, BuildsWithoutTheParserSaySo) {
  if (ReadsObj()) {
    GTEST_SKIP() << "this build has tinyobjloader";
  }
  EXPECT_EQ(LoadScene("a.obj").status().code(), StatusCode::kUnsupported);
  EXPECT_THAT(LoadScene("a.obj").status().message(), HasSubstr("does not read Wavefront OBJ"));
}

}  // namespace
}  // namespace stillray::obj_test
