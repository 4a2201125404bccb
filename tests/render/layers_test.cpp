// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Materials with the extensions of glTF beyond metallic-roughness and transmission.
#include "render/layers_shared.h"

#include <cmath>
#include <limits>
#include <string>

#include "render/surface.h"
#include "test_scenes.h"

namespace stillray::render {
namespace {

using ::testing::HasSubstr;

Material Plastic(float roughness) {
  Material material = Metal(vec3(1.0f), roughness);
  material.metallic = 0.0f;
  return material;
}

/// A quad that fills the picture of a camera that looks straight at it.
SceneBuilder WallOf(const Material& material) {
  SceneBuilder builder;
  builder.scene.cameras[0].yfov = 1e-3f;
  builder.Add(Quad(vec3(-9, -9, -3), vec3(18, 0, 0), vec3(0, 18, 0)), material);
  builder.scene.environment.radiance = vec3(1.0f);
  return builder;
}

Texture UniformTexture(uint8_t r, uint8_t g, uint8_t b, uint8_t a) {
  Texture texture;
  texture.width = texture.height = 1;
  texture.texels = {r, g, b, a};
  return texture;
}

vec3 SpecularAlbedoOf(const SceneBuilder& builder) {
  return Mean(RenderOne(builder.scene, SmallSettings(2, 2, 1)).guides.specular_albedo);
}

vec3 DiffuseAlbedoOf(const SceneBuilder& builder) {
  return Mean(RenderOne(builder.scene, SmallSettings(2, 2, 1)).guides.albedo);
}

void ExpectNear(vec3 found, vec3 expected, float tolerance, const std::string& what = "") {
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(found[k], expected[k], tolerance) << what << " channel " << k;
  }
}

// ((1.5 - 1) / (1.5 + 1))^2 = 0.04, times the factors; the diffuse light is what the largest
// component leaves.
TEST(SpecularTest, ReflectanceAtNormalIncidenceByHand) {
  Material plastic = Plastic(0.0f);
  plastic.specular = 0.5f;
  plastic.specular_color = vec3(2.0f, 1.0f, 0.25f);
  ExpectNear(SpecularAlbedoOf(WallOf(plastic)), vec3(0.04f, 0.02f, 0.005f), 1e-5f);
  ExpectNear(DiffuseAlbedoOf(WallOf(plastic)), vec3(0.96f), 1e-5f);
  plastic.specular_color = vec3(1000.0f, 1.0f, 0.0f);  // reflectances end at 1
  ExpectNear(SpecularAlbedoOf(WallOf(plastic)), vec3(0.5f, 0.02f, 0.0f), 1e-5f);
  ExpectNear(DiffuseAlbedoOf(WallOf(plastic)), vec3(0.5f), 1e-5f);
  plastic.specular = 0.0f;
  ExpectNear(SpecularAlbedoOf(WallOf(plastic)), vec3(0.0f), 0.0f);
  ExpectNear(DiffuseAlbedoOf(WallOf(plastic)), vec3(1.0f), 0.0f);
}

TEST(SpecularTest, MetalsKeepTheirColour) {
  Material metal = Metal(vec3(0.9f, 0.6f, 0.3f), 0.0f);
  metal.specular = 0.1f;
  metal.specular_color = vec3(0.0f, 1.0f, 9.0f);
  ExpectNear(SpecularAlbedoOf(WallOf(metal)), vec3(0.9f, 0.6f, 0.3f), 1e-5f);
}

TEST(SpecularTest, TexturesAreAlphaAndSrgbColour) {
  Material plastic = Plastic(0.0f);
  SceneBuilder builder = WallOf(plastic);
  builder.scene.textures = {UniformTexture(1, 2, 3, 51), UniformTexture(255, 128, 0, 9)};
  builder.scene.materials[0].specular_texture.texture = 0;
  ExpectNear(SpecularAlbedoOf(builder), vec3(0.04f * 0.2f), 1e-6f);
  builder.scene.materials[0].specular_color_texture.texture = 1;
  ExpectNear(SpecularAlbedoOf(builder), 0.008f * vec3(1.0f, SrgbDecode(128.0f / 255), 0.0f), 1e-6f);
}

void ExpectRefused(const Material& material, const std::string& message) {
  const SceneBuilder builder = WallOf(material);
  const auto renderer = Renderer::Create(builder.scene, SmallSettings(2, 2, 1));
  ASSERT_FALSE(renderer.ok()) << message;
  EXPECT_EQ(renderer.status().code(), StatusCode::kInvalidArgument);
  EXPECT_THAT(renderer.status().message(), HasSubstr(message));
}

TEST(MaterialLayersTest, FactorsOutOfRangeAreRefused) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float infinity = std::numeric_limits<float>::infinity();
  const auto changed = [](const auto& change) {
    Material material;
    change(&material);
    return material;
  };
  ExpectRefused(changed([&](Material* m) { m->specular = nan; }),
                "specular is nan, expected 0 to 1");
  ExpectRefused(changed([&](Material* m) { m->specular = 1.5f; }),
                "specular is 1.5, expected 0 to 1");
  ExpectRefused(changed([&](Material* m) { m->specular_color.y = -1.0f; }),
                "specular colour is -1, expected 0 to");
  ExpectRefused(changed([&](Material* m) { m->specular_color.z = infinity; }),
                "specular colour is inf, expected 0 to");
  ExpectRefused(changed([&](Material* m) { m->specular_texture.texture = 2; }),
                "its specular texture is 2, but there are 0");
}

}  // namespace
}  // namespace stillray::render
