// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scene/gltf_builder.h"
#include "scene/gltf_checks.h"
#include "scene/material_textures.h"
#include "scene/test_pictures.h"

namespace stillray::gltf_materials_test {
namespace {

using nlohmann::json;
using test::GltfBuilder;
using test::Loaded;
using ::testing::Contains;
using ::testing::HasSubstr;

Scene WithMaterial(const json& material) {
  GltfBuilder builder;
  builder.AddTriangle();
  builder.UseMaterial(material);
  return Loaded(builder);
}

/// A triangle with texture coordinates and a PNG texture, index 0.
GltfBuilder Textured() {
  GltfBuilder builder;
  builder.AddTriangle();
  const int uvs = builder.AddFloats({0, 1, 1, 1, 0, 0}, "VEC2");
  builder.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = uvs;
  builder.AddTexture(test::EncodePng(test::TestTexels(4, 3), 4, 3), "image/png");
  return builder;
}

TEST(GltfMaterials, MetallicRoughness) {
  const Scene scene = WithMaterial({{"name", "brass"},
                                    {"doubleSided", true},
                                    {"pbrMetallicRoughness",
                                     {{"baseColorFactor", {0.5, 0.25, 0.125, 0.75}},
                                      {"metallicFactor", 0.5},
                                      {"roughnessFactor", 0.25}}}});
  const Material& material = scene.materials.at(0);
  EXPECT_EQ(material.name, "brass");
  EXPECT_EQ(material.base_color, vec4(0.5f, 0.25f, 0.125f, 0.75f));
  EXPECT_EQ(material.metallic, 0.5f);
  EXPECT_EQ(material.roughness, 0.25f);
  EXPECT_TRUE(material.double_sided);
  EXPECT_EQ(scene.meshes.at(0).material, 0);
}

TEST(GltfMaterials, DefaultsAreThoseOfGltf) {
  const Material material = WithMaterial(json::object()).materials.at(0);
  EXPECT_EQ(material.base_color, vec4(1.0f));
  EXPECT_EQ(material.metallic, 1.0f);
  EXPECT_EQ(material.roughness, 1.0f);
  EXPECT_EQ(material.alpha_mode, AlphaMode::kOpaque);
  EXPECT_EQ(material.alpha_cutoff, 0.5f);
  EXPECT_EQ(material.ior, 1.5f);
  EXPECT_FALSE(material.solid);
  EXPECT_FALSE(material.double_sided);
  EXPECT_FALSE(material.emits());
  EXPECT_EQ(material.base_color_texture.texture, -1);
}

TEST(GltfMaterials, EmissiveStrengthMultipliesTheFactor) {
  const Material material =
      WithMaterial(
          {{"emissiveFactor", {1, 0.5, 0.25}},
           {"extensions", {{"KHR_materials_emissive_strength", {{"emissiveStrength", 40}}}}}})
          .materials.at(0);
  EXPECT_EQ(material.emission, vec3(40, 20, 10));
  EXPECT_TRUE(material.emits());
}

TEST(GltfMaterials, EmissionBeyondAFloatIsRefused) {
  GltfBuilder file;
  file.AddTriangle();
  file.UseMaterial(
      {{"emissiveFactor", {1, 1, 1}},
       {"extensions", {{"KHR_materials_emissive_strength", {{"emissiveStrength", 3e38}}}}}});
  const Status status = file.Load().status();
  EXPECT_EQ(status.code(), StatusCode::kBadData);
  EXPECT_THAT(status.message(), HasSubstr("materials[0].emissiveFactor: times an "
                                          "emissiveStrength of 3e+38 is beyond a 32-bit float"));
}

TEST(GltfMaterials, TransmissionIorAndVolume) {
  const Material material =
      WithMaterial({{"extensions",
                     {{"KHR_materials_transmission", {{"transmissionFactor", 0.75}}},
                      {"KHR_materials_ior", {{"ior", 1.33}}},
                      {"KHR_materials_volume",
                       {{"thicknessFactor", 0.1},
                        {"attenuationColor", {0.5, 1, 0.25}},
                        {"attenuationDistance", 2}}}}}})
          .materials.at(0);
  EXPECT_EQ(material.transmission, 0.75f);
  EXPECT_FLOAT_EQ(material.ior, 1.33f);
  EXPECT_TRUE(material.solid);
  EXPECT_EQ(material.attenuation_color, vec3(0.5f, 1.0f, 0.25f));
  EXPECT_EQ(material.attenuation_distance, 2.0f);
}

TEST(GltfMaterials, Specular) {
  const Material plain =
      WithMaterial({{"extensions", {{"KHR_materials_specular", json::object()}}}}).materials.at(0);
  EXPECT_EQ(plain.specular, 1.0f);
  EXPECT_EQ(plain.specular_color, vec3(1.0f));
  const Scene scene =
      WithMaterial({{"extensions",
                     {{"KHR_materials_specular",
                       {{"specularFactor", 0.25}, {"specularColorFactor", {3, 0.5, -1}}}}}}});
  EXPECT_EQ(scene.materials.at(0).specular, 0.25f);
  EXPECT_EQ(scene.materials.at(0).specular_color, vec3(3.0f, 0.5f, 0.0f));
  EXPECT_THAT(scene.warnings, Contains(HasSubstr("materials[0].extensions.KHR_materials_specular."
                                                 "specularColorFactor: -1 is below 0")));
}

TEST(GltfMaterials, Clearcoat) {
  const Scene scene =
      WithMaterial({{"extensions",
                     {{"KHR_materials_clearcoat",
                       {{"clearcoatFactor", 0.75}, {"clearcoatRoughnessFactor", -0.5}}}}}});
  EXPECT_EQ(scene.materials.at(0).clearcoat, 0.75f);
  EXPECT_EQ(scene.materials.at(0).clearcoat_roughness, 0.0f);
  EXPECT_THAT(scene.warnings, Contains(HasSubstr("materials[0].extensions.KHR_materials_clearcoat."
                                                 "clearcoatRoughnessFactor: -0.5 is outside")));
  EXPECT_EQ(WithMaterial(json::object()).materials.at(0).clearcoat, 0.0f);
}

TEST(GltfMaterials, AMapOfTheClearCoatAloneNeedsTangents) {
  GltfBuilder builder = Textured();
  builder.UseMaterial({{"extensions",
                        {{"KHR_materials_clearcoat",
                          {{"clearcoatFactor", 1}, {"clearcoatNormalTexture", {{"index", 0}}}}}}}});
  const Scene scene = Loaded(builder);
  ASSERT_EQ(scene.meshes.at(0).tangents.size(), 3u);
  EXPECT_EQ(scene.meshes.at(0).tangents[0], vec4(1, 0, 0, 1));
}

TEST(GltfMaterials, Sheen) {
  const Scene scene =
      WithMaterial({{"extensions",
                     {{"KHR_materials_sheen",
                       {{"sheenColorFactor", {0.5, 2, 0.25}}, {"sheenRoughnessFactor", 0.75}}}}}});
  EXPECT_EQ(scene.materials.at(0).sheen_color, vec3(0.5f, 1.0f, 0.25f));
  EXPECT_EQ(scene.materials.at(0).sheen_roughness, 0.75f);
  EXPECT_THAT(scene.warnings, Contains(HasSubstr("materials[0].extensions.KHR_materials_sheen."
                                                 "sheenColorFactor: 2 is outside 0..1")));
  const Material plain = WithMaterial(json::object()).materials.at(0);
  EXPECT_EQ(plain.sheen_color, vec3(0.0f));
  EXPECT_EQ(plain.sheen_roughness, 0.0f);
}

TEST(GltfMaterials, DiffuseTransmission) {
  const Scene scene = WithMaterial(
      {{"extensions",
        {{"KHR_materials_diffuse_transmission",
          {{"diffuseTransmissionFactor", 7}, {"diffuseTransmissionColorFactor", {0.5, 0, -3}}}}}}});
  EXPECT_EQ(scene.materials.at(0).diffuse_transmission, 1.0f);
  EXPECT_EQ(scene.materials.at(0).diffuse_transmission_color, vec3(0.5f, 0.0f, 0.0f));
  EXPECT_THAT(scene.warnings, Contains(HasSubstr("diffuseTransmissionFactor: 7 is outside")));
  EXPECT_THAT(scene.warnings, Contains(HasSubstr("diffuseTransmissionColorFactor: -3 is outside")));
}

TEST(GltfMaterials, Anisotropy) {
  const json extension = {{"anisotropyStrength", 1.5}, {"anisotropyRotation", -0.5}};
  const Scene scene = WithMaterial({{"extensions", {{"KHR_materials_anisotropy", extension}}}});
  EXPECT_EQ(scene.materials.at(0).anisotropy, 1.0f);
  EXPECT_EQ(scene.materials.at(0).anisotropy_rotation, -0.5f);
  EXPECT_THAT(scene.warnings, Contains(HasSubstr("materials[0].extensions.KHR_materials_anisotropy."
                                                 "anisotropyStrength: 1.5 is outside 0..1")));
  const Material plain = WithMaterial(json::object()).materials.at(0);
  EXPECT_EQ(plain.anisotropy, 0.0f);
  EXPECT_EQ(plain.anisotropy_rotation, 0.0f);
}

TEST(GltfMaterials, AnisotropyNeedsTangents) {
  const json material = {
      {"extensions", {{"KHR_materials_anisotropy", {{"anisotropyStrength", 0.5}}}}}};
  GltfBuilder builder = Textured();
  builder.UseMaterial(material);
  const Scene scene = Loaded(builder);
  ASSERT_EQ(scene.meshes.at(0).tangents.size(), 3u);
  EXPECT_EQ(scene.meshes.at(0).tangents[0], vec4(1, 0, 0, 1));
  const Scene without = WithMaterial(material);
  EXPECT_TRUE(without.meshes.at(0).tangents.empty());
  EXPECT_THAT(without.warnings, Contains(HasSubstr("neither TANGENT nor TEXCOORD_0")));
}

TEST(GltfMaterials, Iridescence) {
  const json extension = {{"iridescenceFactor", 0.5},
                          {"iridescenceIor", 0.5},
                          {"iridescenceThicknessMinimum", 200},
                          {"iridescenceThicknessMaximum", -7}};
  const Scene scene = WithMaterial({{"extensions", {{"KHR_materials_iridescence", extension}}}});
  const Material& material = scene.materials.at(0);
  EXPECT_EQ(material.iridescence, 0.5f);
  EXPECT_EQ(material.iridescence_ior, 1.0f);
  EXPECT_EQ(material.iridescence_thickness_min, 200.0f);
  EXPECT_EQ(material.iridescence_thickness_max, 0.0f);
  EXPECT_THAT(scene.warnings, Contains(HasSubstr("iridescenceIor: 0.5 is outside 1..10")));
  EXPECT_THAT(scene.warnings, Contains(HasSubstr("iridescenceThicknessMaximum: -7 is outside")));
  const Material plain = WithMaterial(json::object()).materials.at(0);
  EXPECT_EQ(plain.iridescence, 0.0f);
  EXPECT_EQ(plain.iridescence_ior, 1.3f);
  EXPECT_EQ(plain.iridescence_thickness_min, 100.0f);
  EXPECT_EQ(plain.iridescence_thickness_max, 400.0f);
}

TEST(GltfMaterials, VolumeScatter) {
  json extensions = {
      {"KHR_materials_volume",
       {{"thicknessFactor", 1}, {"attenuationColor", {0.5, 0.5, 0.5}}, {"attenuationDistance", 2}}},
      {"KHR_materials_volume_scatter",
       {{"multiscatterColor", {0.5, 1.5, 0}}, {"scatterAnisotropy", 1}}}};
  const Scene scene = WithMaterial({{"extensions", extensions}});
  EXPECT_EQ(scene.materials.at(0).multiscatter_color, vec3(0.5f, 1.0f, 0.0f));
  EXPECT_EQ(scene.materials.at(0).scatter_anisotropy, 0.999f);
  EXPECT_THAT(scene.warnings, Contains(HasSubstr("multiscatterColor: 1.5 is outside 0..1")));
  EXPECT_THAT(scene.warnings, Contains(HasSubstr("scatterAnisotropy: 1 is outside")));
  EXPECT_THAT(scene.warnings, Not(Contains(HasSubstr("scatters no light"))));
  extensions["KHR_materials_volume_scatter"] = {{"multiscatterColorFactor", {0.25, 0.5, 1}},
                                                {"multiscatterColorTexture", {{"index", 0}}}};
  extensions["KHR_materials_volume"].erase("attenuationDistance");
  const Scene later = WithMaterial({{"extensions", extensions}});
  EXPECT_EQ(later.materials.at(0).multiscatter_color, vec3(0.25f, 0.5f, 1.0f));
  EXPECT_EQ(later.materials.at(0).scatter_anisotropy, 0.0f);
  EXPECT_THAT(later.warnings, Contains(HasSubstr("multiscatterColorTexture: is left out")));
  EXPECT_THAT(later.warnings, Contains(HasSubstr("multiscatterColorFactor: scatters no light")));
  extensions["KHR_materials_volume"] = {{"thicknessFactor", 1}, {"attenuationDistance", 2}};
  EXPECT_THAT(WithMaterial({{"extensions", extensions}}).warnings,
              Contains(HasSubstr("attenuationColor below 1")));
  EXPECT_EQ(WithMaterial(json::object()).materials.at(0).multiscatter_color, vec3(0.0f));
}

/// A texture or a number of an extension that is damaged is an error that names it.
TEST(GltfMaterials, DamagedExtensionsAreRefused) {
  const auto refused = [](const char* extension, const json& content, const std::string& message) {
    GltfBuilder builder;
    builder.AddTriangle();
    builder.UseMaterial({{"extensions", {{extension, content}}}});
    const Status status = builder.Load().status();
    EXPECT_EQ(status.code(), StatusCode::kBadData) << message;
    EXPECT_THAT(status.message(), HasSubstr(std::string(extension) + "." + message));
  };
  refused("KHR_materials_specular", {{"specularFactor", nullptr}},
          "specularFactor: expected a number, found null");
  refused("KHR_materials_specular", {{"specularColorFactor", {1, 2}}},
          "specularColorFactor: expected 3 numbers, found 2");
  refused("KHR_materials_specular", {{"specularTexture", {{"index", 3}}}},
          "specularTexture.index: index 3 is out of range");
  refused("KHR_materials_specular", {{"specularColorTexture", json::object()}},
          "specularColorTexture.index: missing");
  refused("KHR_materials_clearcoat", {{"clearcoatFactor", "much"}},
          "clearcoatFactor: expected a number, found string");
  refused("KHR_materials_clearcoat", {{"clearcoatNormalTexture", {{"index", 0}}}},
          "clearcoatNormalTexture.index: index 0 is out of range");
  refused("KHR_materials_diffuse_transmission", {{"diffuseTransmissionFactor", {0.5}}},
          "diffuseTransmissionFactor: expected a number, found array");
  refused("KHR_materials_anisotropy", {{"anisotropyRotation", "left"}},
          "anisotropyRotation: expected a number, found string");
  refused("KHR_materials_volume_scatter", {{"multiscatterColor", {1, 1}}},
          "multiscatterColor: expected 3 numbers, found 2");
  refused("KHR_materials_iridescence", {{"iridescenceThicknessTexture", {{"index", 5}}}},
          "iridescenceThicknessTexture.index: index 5 is out of range");
  refused("KHR_materials_sheen", {{"sheenColorFactor", {1, nullptr, 1}}},
          "sheenColorFactor[1]: expected a number, found null");
}

TEST(GltfMaterials, AVolumeWithoutThicknessIsASheet) {
  const Material material =
      WithMaterial({{"extensions", {{"KHR_materials_volume", json::object()}}}}).materials.at(0);
  EXPECT_FALSE(material.solid);
  EXPECT_TRUE(std::isinf(material.attenuation_distance));
}

TEST(GltfMaterials, AlphaModes) {
  EXPECT_EQ(WithMaterial({{"alphaMode", "BLEND"}}).materials.at(0).alpha_mode, AlphaMode::kBlend);
  const Material mask =
      WithMaterial({{"alphaMode", "MASK"}, {"alphaCutoff", 0.25}}).materials.at(0);
  EXPECT_EQ(mask.alpha_mode, AlphaMode::kMask);
  EXPECT_EQ(mask.alpha_cutoff, 0.25f);
}

TEST(GltfMaterials, FactorsOutOfRangeAreMovedIntoIt) {
  const Scene scene = WithMaterial({{"pbrMetallicRoughness", {{"roughnessFactor", 1.5}}}});
  EXPECT_EQ(scene.materials.at(0).roughness, 1.0f);
  EXPECT_THAT(
      scene.warnings,
      Contains(HasSubstr("materials[0].pbrMetallicRoughness.roughnessFactor: 1.5 is outside")));
}

TEST(GltfMaterials, UnlitIsShownAsEmission) {
  const Material material =
      WithMaterial({{"pbrMetallicRoughness", {{"baseColorFactor", {0.5, 0.25, 0.125, 1}}}},
                    {"extensions", {{"KHR_materials_unlit", json::object()}}}})
          .materials.at(0);
  EXPECT_EQ(material.emission, vec3(0.5f, 0.25f, 0.125f));
  EXPECT_EQ(vec3(material.base_color), vec3(0.0f));
}

TEST(GltfTextures, EverySlotIsRead) {
  GltfBuilder builder = Textured();
  builder.UseMaterial(
      {{"pbrMetallicRoughness",
        {{"baseColorTexture", {{"index", 0}}}, {"metallicRoughnessTexture", {{"index", 0}}}}},
       {"normalTexture", {{"index", 0}, {"scale", 0.5}}},
       {"emissiveTexture", {{"index", 0}}},
       {"occlusionTexture", {{"index", 0}}},
       {"extensions",
        {{"KHR_materials_transmission", {{"transmissionTexture", {{"index", 0}}}}},
         {"KHR_materials_specular",
          {{"specularTexture", {{"index", 0}}}, {"specularColorTexture", {{"index", 0}}}}},
         {"KHR_materials_clearcoat",
          {{"clearcoatTexture", {{"index", 0}}},
           {"clearcoatRoughnessTexture", {{"index", 0}}},
           {"clearcoatNormalTexture", {{"index", 0}, {"scale", 0.25}}}}},
         {"KHR_materials_sheen",
          {{"sheenColorTexture", {{"index", 0}}}, {"sheenRoughnessTexture", {{"index", 0}}}}},
         {"KHR_materials_diffuse_transmission",
          {{"diffuseTransmissionTexture", {{"index", 0}}},
           {"diffuseTransmissionColorTexture", {{"index", 0}}}}},
         {"KHR_materials_anisotropy", {{"anisotropyTexture", {{"index", 0}}}}},
         {"KHR_materials_iridescence",
          {{"iridescenceTexture", {{"index", 0}}},
           {"iridescenceThicknessTexture", {{"index", 0}}}}}}}});
  const Scene scene = Loaded(builder);
  const Material& material = scene.materials.at(0);
  for (const MaterialTexture& texture : kMaterialTextures) {
    const TextureRef& ref = material.*texture.slot;
    EXPECT_EQ(ref.texture, 0) << texture.name;
    EXPECT_EQ(ref.transform, mat3(1.0f)) << texture.name;
  }
  EXPECT_EQ(material.normal_scale, 0.5f);
  EXPECT_EQ(material.clearcoat_normal_scale, 0.25f);
  ASSERT_EQ(scene.textures.size(), 1u) << "one picture with one sampler is one texture";
  EXPECT_EQ(scene.textures[0].width, 4);
  EXPECT_EQ(scene.textures[0].height, 3);
  EXPECT_EQ(scene.textures[0].texels, test::TestTexels(4, 3));
  EXPECT_EQ(scene.meshes.at(0).tangents.size(), 3u) << "a normal map needs tangents";
  EXPECT_EQ(scene.meshes.at(0).tangents[0], vec4(1, 0, 0, 1));
}

TEST(GltfTextures, SamplersMakeTexturesOfTheirOwn) {
  GltfBuilder builder = Textured();
  builder.Add("samplers", {{"wrapS", 33071}, {"wrapT", 33648}, {"magFilter", 9728}});
  builder.Add("textures", {{"source", 0}, {"sampler", 0}});
  builder.UseMaterial({{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}},
                       {"emissiveTexture", {{"index", 1}}}});
  const Scene scene = Loaded(builder);
  ASSERT_EQ(scene.textures.size(), 2u);
  EXPECT_EQ(scene.textures[0].wrap_u, Wrap::kRepeat);
  EXPECT_FALSE(scene.textures[0].nearest);
  EXPECT_EQ(scene.textures[1].wrap_u, Wrap::kClamp);
  EXPECT_EQ(scene.textures[1].wrap_v, Wrap::kMirror);
  EXPECT_TRUE(scene.textures[1].nearest);
  EXPECT_EQ(scene.textures[1].texels, test::TestTexels(4, 3));
}

TEST(GltfTextures, TransformIsTranslationTimesRotationTimesScale) {
  GltfBuilder builder = Textured();
  builder.UseMaterial({{"pbrMetallicRoughness",
                        {{"baseColorTexture",
                          {{"index", 0},
                           {"extensions",
                            {{"KHR_texture_transform",
                              {{"offset", {0.5, 0.25}},
                               {"rotation", 1.5707963267948966},
                               {"scale", {2, 4}},
                               {"texCoord", 1}}}}}}}}}});
  const Scene scene = Loaded(builder);
  const TextureRef& ref = scene.materials.at(0).base_color_texture;
  EXPECT_EQ(ref.uv_set, 1);
  // Scaled to (2, 0) and (0, 4). A quarter turn counter-clockwise, with v down: u turns to -v and v
  // to u.
  const vec3 u = ref.transform * vec3(1, 0, 1);
  const vec3 v = ref.transform * vec3(0, 1, 1);
  EXPECT_NEAR(u.x, 0.5f, 1e-6f);
  EXPECT_NEAR(u.y, 0.25f - 2.0f, 1e-6f);
  EXPECT_NEAR(v.x, 0.5f + 4.0f, 1e-6f);
  EXPECT_NEAR(v.y, 0.25f, 1e-6f);
  // The mesh has no second set.
  EXPECT_THAT(scene.warnings, Contains(HasSubstr("has no TEXCOORD_1")));
  EXPECT_EQ(scene.meshes.at(0).uv[1].size(), 3u);
}

TEST(GltfTextures, WebpThroughItsExtension) {
  GltfBuilder builder = Textured();
  const int view = builder.AddView(test::EncodeWebp(test::TestTexels(5, 2), 5, 2));
  const int image = builder.Add("images", {{"bufferView", view}, {"mimeType", "image/webp"}});
  builder.json["textures"][0] = {{"source", 0},
                                 {"extensions", {{"EXT_texture_webp", {{"source", image}}}}}};
  builder.json["extensionsRequired"] = {"EXT_texture_webp"};
  builder.UseMaterial({{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}});
  const Scene scene = Loaded(builder);
  ASSERT_EQ(scene.textures.size(), 1u);
  EXPECT_EQ(scene.textures[0].width, 5);
  EXPECT_EQ(scene.textures[0].texels, test::TestTexels(5, 2));
}

TEST(GltfTextures, JpegIsDecodedAndOpaque) {
  GltfBuilder builder = Textured();
  builder.AddTexture(test::EncodeJpeg(std::vector<uint8_t>(8 * 8 * 4, 200), 8, 8), "image/jpeg");
  builder.UseMaterial({{"emissiveTexture", {{"index", 1}}}});
  const Scene scene = Loaded(builder);
  ASSERT_EQ(scene.textures.size(), 1u);
  EXPECT_NEAR(scene.textures[0].texels[0], 200, 2);
  EXPECT_EQ(scene.textures[0].texels[3], 255);
}

TEST(GltfTextures, APictureGivenOnlyThroughAnUnknownExtensionIsUnsupported) {
  GltfBuilder builder = Textured();
  builder.json["textures"][0] = {{"extensions", {{"KHR_texture_basisu", {{"source", 0}}}}}};
  builder.UseMaterial({{"emissiveTexture", {{"index", 0}}}});
  const Result<Scene> scene = builder.Load();
  ASSERT_FALSE(scene.ok());
  EXPECT_EQ(scene.status().code(), StatusCode::kUnsupported);
  EXPECT_THAT(scene.status().message(), HasSubstr("textures[0]"));
  EXPECT_THAT(scene.status().message(), HasSubstr("KHR_texture_basisu"));
}

// Fifteen black pictures of some kilobytes take a gigabyte; they are refused before one is decoded.
TEST(GltfTextures, FewBytesMakeNoGigabytes) {
  constexpr int kSide = 4096;
  const std::vector<uint8_t> png =
      test::EncodePng(std::vector<uint8_t>(size_t{4} * kSide * kSide, 0), kSide, kSide);
  GltfBuilder file;
  file.AddTriangle();
  const int view = file.AddView(png);
  const char* kSlots[] = {"normalTexture", "emissiveTexture"};
  for (int i = 0; i < 15; ++i) {
    const int image = file.Add("images", {{"bufferView", view}, {"mimeType", "image/png"}});
    const int texture = file.Add("textures", {{"source", image}});
    if (i % 3 == 0) {
      file.AddTriangle();
      file.UseMaterial({{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", texture}}}}}});
    } else {
      file.json["materials"].back()[kSlots[i % 3 - 1]] = {{"index", texture}};
    }
  }
  const Status status = file.Load().status();
  EXPECT_EQ(status.code(), StatusCode::kUnsupported);
  EXPECT_THAT(status.message(), HasSubstr("4096x4096 texels in "));
  EXPECT_THAT(status.message(), HasSubstr("with it the textures take "));
}

TEST(GltfExtensions, AnUnknownRequiredOneIsRefusedByName) {
  GltfBuilder builder;
  builder.AddTriangle();
  builder.json["extensionsRequired"] = {"KHR_texture_transform", "KHR_draco_mesh_compression"};
  const Result<Scene> scene = builder.Load();
  ASSERT_FALSE(scene.ok());
  EXPECT_EQ(scene.status().code(), StatusCode::kUnsupported);
  EXPECT_THAT(scene.status().message(), HasSubstr("KHR_draco_mesh_compression"));
}

TEST(GltfExtensions, AnUnknownOptionalOneIsAWarning) {
  GltfBuilder builder;
  builder.AddTriangle();
  builder.json["extensionsUsed"] = {"KHR_materials_dispersion", "KHR_materials_sheen"};
  const Scene scene = Loaded(builder);
  EXPECT_THAT(scene.warnings, Contains(HasSubstr("KHR_materials_dispersion")));
  EXPECT_THAT(scene.warnings, ::testing::Not(Contains(HasSubstr("KHR_materials_sheen"))));
}

}  // namespace
}  // namespace stillray::gltf_materials_test
