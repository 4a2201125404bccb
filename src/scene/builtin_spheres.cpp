// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Spheres of every roughness in metal, plastic and glass, on tiles under a sky with a large soft
/// sun.
#include <array>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "scene/builtin.h"

namespace stillray {

namespace {

constexpr int kColumns = 6;
constexpr float kRadius = 0.45f;
constexpr float kSpacing = 1.1f;

/// Roughness of a column: 0, 0.2, ... 1.
float ColumnRoughness(int column) {
  return static_cast<float>(column) / (kColumns - 1);
}

int AddGlass(Scene* scene, const std::string& name, int column) {
  // Transmittance over a distance of one radius.
  static const std::array<vec3, kColumns> kTints = {
      vec3(1.0f, 1.0f, 1.0f),   vec3(0.95f, 0.55f, 0.35f), vec3(0.90f, 0.85f, 0.35f),
      vec3(0.40f, 0.85f, 0.5f), vec3(0.35f, 0.65f, 0.95f), vec3(0.75f, 0.45f, 0.9f)};
  // Half the roughness range of the other rows: rougher glass only turns grey.
  const int index = AddMaterial(scene, name, vec3(1.0f), 0.0f, 0.5f * ColumnRoughness(column));
  Material& glass = scene->materials.back();
  glass.transmission = 1.0f;
  glass.solid = true;
  glass.attenuation_color = kTints[static_cast<size_t>(column)];
  glass.attenuation_distance = kRadius;
  return index;
}

void AddSphereRows(Scene* scene) {
  constexpr int kSlices = 128;
  constexpr int kStacks = 64;
  const auto add = [&](const std::string& name, int material, int column, float z) {
    const float x = (static_cast<float>(column) - 0.5f * (kColumns - 1)) * kSpacing;
    AddObject(scene, name, MakeSphere(kRadius, kSlices, kStacks, material), vec3(x, kRadius, z));
  };
  for (int column = 0; column < kColumns; ++column) {
    const float roughness = ColumnRoughness(column);
    const std::string metal = fmt::format("metal, roughness {:.1f}", roughness);
    add(metal, AddMaterial(scene, metal, vec3(0.95f, 0.72f, 0.42f), 1.0f, roughness), column,
        -kSpacing);
    const std::string plastic = fmt::format("plastic, roughness {:.1f}", roughness);
    add(plastic, AddMaterial(scene, plastic, vec3(0.70f, 0.10f, 0.08f), 0.0f, roughness), column,
        0.0f);
    const std::string glass = fmt::format("glass, roughness {:.1f}", 0.5f * roughness);
    add(glass, AddGlass(scene, glass, column), column, kSpacing);
  }
}

}  // namespace

Scene MakeSpheresScene() {
  Scene scene;
  scene.environment = MakeSky();
  AddTiledGround(&scene, 0.6f, 23);
  AddSphereRows(&scene);
  AddSwingingCamera(&scene, vec3(0.0f, 0.35f, 0.1f), vec2(6.5f, 6.25f), 0.42f);
  return scene;
}

}  // namespace stillray
