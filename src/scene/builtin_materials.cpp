// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// A grid of spheres, each a material of one of glTF's extensions, on tiles under a sky with a
/// large soft sun. Rows from the back: specular, clear coat, sheen, diffuse transmission.
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "scene/builtin.h"

namespace stillray {

namespace {

constexpr float kPi = 3.14159265f;
constexpr float kRadius = 0.44f;
constexpr float kSpacing = 1.06f;
constexpr float kRowSpacing = 1.3f;

using Row = std::vector<Material>;

Material Plain(const std::string& name, vec3 colour, float metallic, float roughness) {
  Material material;
  material.name = name;
  material.base_color = vec4(colour, 1.0f);
  material.metallic = metallic;
  material.roughness = roughness;
  return material;
}

Row SpecularRow() {
  Row row;
  const vec3 green(0.05f, 0.16f, 0.08f);
  for (const float weight : {0.0f, 0.5f, 1.0f}) {
    row.push_back(Plain(fmt::format("specular {:.1f}", weight), green, 0.0f, 0.25f));
    row.back().specular = weight;
  }
  const std::pair<const char*, vec3> tints[] = {{"gold", vec3(12.0f, 7.0f, 2.0f)},
                                                {"blue", vec3(1.0f, 4.0f, 14.0f)},
                                                {"red", vec3(14.0f, 1.5f, 1.0f)}};
  for (const auto& [name, colour] : tints) {
    row.push_back(Plain(fmt::format("specular, {}", name), green, 0.0f, 0.25f));
    row.back().specular_color = colour;
  }
  return row;
}

/// Waves of a surface that repeat without seams, as a normal map.
Texture MakeWaves() {
  constexpr int kSize = 256;
  constexpr float kWaves = 24.0f;
  constexpr float kSlope = 0.22f;
  Texture texture;
  texture.name = "waves";
  texture.width = texture.height = kSize;
  const auto byte = [](float x) {
    return static_cast<uint8_t>(std::lround((0.5f + 0.5f * x) * 255.0f));
  };
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x) {
      const float u = (static_cast<float>(x) + 0.5f) / kSize * 2.0f * kPi;
      const float v = (static_cast<float>(y) + 0.5f) / kSize * 2.0f * kPi;
      const float across = std::sin(kWaves * u + 2.0f * std::sin(3.0f * v));
      const float along = std::sin(0.5f * kWaves * v + 2.0f * std::sin(5.0f * u));
      const vec3 normal = glm::normalize(vec3(kSlope * across, kSlope * along, 1.0f));
      texture.texels.insert(texture.texels.end(),
                            {byte(normal.x), byte(normal.y), byte(normal.z), 255});
    }
  }
  return texture;
}

Row ClearCoatRow(Scene* scene) {
  const int waves = static_cast<int>(scene->textures.size());
  scene->textures.push_back(MakeWaves());
  Row row;
  const vec3 paint(0.55f, 0.03f, 0.02f);
  row.push_back(Plain("paint without coat", paint, 1.0f, 0.55f));
  for (const float roughness : {0.0f, 0.2f, 0.4f}) {
    row.push_back(Plain(fmt::format("coat, roughness {:.1f}", roughness), paint, 1.0f, 0.55f));
    row.back().clearcoat = 1.0f;
    row.back().clearcoat_roughness = roughness;
  }
  row.push_back(Plain("coat over waves", vec3(0.05f, 0.12f, 0.45f), 1.0f, 0.4f));
  row.back().clearcoat = 1.0f;
  row.back().normal_texture.texture = waves;
  row.push_back(Plain("wavy coat", vec3(0.02f), 0.0f, 0.6f));
  row.back().clearcoat = 1.0f;
  row.back().clearcoat_normal_texture.texture = waves;
  return row;
}

Row SheenRow() {
  Row row;
  row.push_back(Plain("cloth without sheen", vec3(0.12f, 0.02f, 0.06f), 0.0f, 1.0f));
  for (const float roughness : {0.15f, 0.3f, 0.5f, 1.0f}) {
    row.push_back(row.front());
    row.back().name = fmt::format("sheen, roughness {:.2f}", roughness);
    row.back().sheen_color = vec3(1.0f, 0.55f, 0.75f);
    row.back().sheen_roughness = roughness;
  }
  row.push_back(row[3]);
  row.back().name = "coated sheen";
  row.back().clearcoat = 1.0f;
  return row;
}

Row DiffuseTransmissionRow() {
  Row row;
  const vec3 colour(0.75f, 0.72f, 0.60f);
  for (const float part : {0.0f, 0.35f, 0.7f, 1.0f}) {
    row.push_back(Plain(fmt::format("diffuse transmission {:.2f}", part), colour, 0.0f, 0.6f));
    row.back().diffuse_transmission = part;
    row.back().diffuse_transmission_color = vec3(0.95f, 0.62f, 0.25f);
  }
  for (const vec3& tint : {vec3(0.30f, 0.85f, 0.45f), vec3(0.85f, 0.30f, 0.55f)}) {
    row.push_back(row.back());
    row.back().name = fmt::format("wax {}", row.size() - 4);
    row.back().diffuse_transmission = 0.8f;
    row.back().diffuse_transmission_color = vec3(1.0f);
    row.back().solid = true;
    row.back().attenuation_color = tint;
    row.back().attenuation_distance = kRadius;
  }
  return row;
}

void AddRow(Scene* scene, Row row, float z) {
  constexpr int kSlices = 128;
  constexpr int kStacks = 64;
  const float middle = 0.5f * static_cast<float>(row.size() - 1);
  for (size_t i = 0; i < row.size(); ++i) {
    const int index = static_cast<int>(scene->materials.size());
    const std::string name = row[i].name;
    scene->materials.push_back(std::move(row[i]));
    AddObject(scene, name, MakeSphere(kRadius, kSlices, kStacks, index),
              vec3((static_cast<float>(i) - middle) * kSpacing, kRadius, z));
  }
}

}  // namespace

Scene MakeMaterialsScene() {
  Scene scene;
  scene.environment = MakeSky();
  AddTiledGround(&scene, 0.7f, 29);
  AddRow(&scene, SpecularRow(), -1.5f * kRowSpacing);
  AddRow(&scene, ClearCoatRow(&scene), -0.5f * kRowSpacing);
  AddRow(&scene, SheenRow(), 0.5f * kRowSpacing);
  AddRow(&scene, DiffuseTransmissionRow(), 1.5f * kRowSpacing);
  AddSwingingCamera(&scene, vec3(0.0f, 0.25f, 0.1f), vec2(6.7f, 6.45f), 0.68f);
  return scene;
}

}  // namespace stillray
