// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Spheres of every roughness in metal, plastic and glass, on tiles under a sky with a large soft
/// sun.
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "core/parallel.h"
#include "scene/builtin.h"

namespace stillray {

namespace {

constexpr float kPi = 3.14159265f;
constexpr int kColumns = 6;
constexpr float kRadius = 0.45f;
constexpr float kSpacing = 1.1f;

/// Radiance of the sky in a direction of unit length. The sun is a disc of 9 degrees radius with a
/// soft edge: a real one would be two thousand times as bright and as hard to sample.
vec3 SkyRadiance(vec3 direction) {
  const vec3 zenith(0.24f, 0.42f, 0.80f);
  const vec3 horizon(0.85f, 0.95f, 1.05f);
  const vec3 ground(0.22f, 0.20f, 0.18f);
  const vec3 sun_radiance(78.0f, 66.0f, 50.0f);
  static const vec3 sun_direction = glm::normalize(vec3(-0.65f, 0.75f, 0.55f));
  constexpr float kSunRadius = 9.0f * kPi / 180.0f;
  constexpr float kSunEdge = 4.0f * kPi / 180.0f;
  constexpr float kHorizonBlur = 0.03f;
  const float up = std::max(direction.y, 0.0f);
  const vec3 sky = glm::mix(horizon, zenith, std::pow(up, 0.5f));
  const float above = glm::smoothstep(-kHorizonBlur, kHorizonBlur, direction.y);
  const float angle = std::acos(glm::clamp(glm::dot(direction, sun_direction), -1.0f, 1.0f));
  const float sun = 1.0f - glm::smoothstep(kSunRadius - kSunEdge, kSunRadius, angle);
  const float halo = 0.8f * std::exp(-angle * 4.0f);
  return glm::mix(ground, sky + vec3(1.0f, 0.9f, 0.75f) * halo, above) + sun_radiance * sun;
}

Environment MakeSky() {
  constexpr int kWidth = 512;
  constexpr int kHeight = 256;
  Environment environment;
  environment.radiance = vec3(1.0f);
  environment.map = Image3(kWidth, kHeight);
  ParallelRows(kHeight, 16, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      const float theta = kPi * (static_cast<float>(y) + 0.5f) / kHeight;
      for (int x = 0; x < kWidth; ++x) {
        const float phi = 2.0f * kPi * ((static_cast<float>(x) + 0.5f) / kWidth - 0.5f);
        const vec3 direction(std::sin(theta) * std::sin(phi), std::cos(theta),
                             -std::sin(theta) * std::cos(phi));
        const vec3 radiance = SkyRadiance(direction);
        for (int c = 0; c < 3; ++c) {
          environment.map[c](x, y) = radiance[c];
        }
      }
    }
  });
  return environment;
}

/// Roughness of a column: 0, 0.2, ... 1.
float ColumnRoughness(int column) {
  return static_cast<float>(column) / (kColumns - 1);
}

int AddGlass(Scene* scene, const std::string& name, int column) {
  // The transmittance over one radius.
  static const std::array<vec3, kColumns> kTints = {
      vec3(1.0f, 1.0f, 1.0f),   vec3(0.95f, 0.55f, 0.35f), vec3(0.90f, 0.85f, 0.35f),
      vec3(0.40f, 0.85f, 0.5f), vec3(0.35f, 0.65f, 0.95f), vec3(0.75f, 0.45f, 0.9f)};
  // Rougher glass only becomes grey: half the range of the other rows.
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
  const int tiles =
      AddTexturedMaterial(&scene,
                          MakeTiles("ground", 1024, 8, vec3(0.46f, 0.42f, 0.36f),
                                    vec3(0.20f, 0.20f, 0.21f), vec3(0.12f, 0.11f, 0.10f), 23),
                          0.6f);
  constexpr float kGroundHalf = 40.0f;
  constexpr float kMetresPerTexture = 4.0f;
  AddObject(&scene, "ground",
            MakeQuad(vec3(-kGroundHalf, 0.0f, -kGroundHalf), vec3(0.0f, 0.0f, 2.0f * kGroundHalf),
                     vec3(2.0f * kGroundHalf, 0.0f, 0.0f),
                     vec2(2.0f * kGroundHalf / kMetresPerTexture), tiles),
            vec3(0.0f));
  AddSphereRows(&scene);
  constexpr float kFieldOfView = 0.61f;
  AddAnimatedCamera(&scene, kFieldOfView, [](float t) {
    const vec3 target(0.0f, 0.35f, 0.1f);
    const float angle = glm::mix(-0.07f, 0.07f, t);
    const float distance = glm::mix(6.5f, 6.25f, t);
    const vec3 offset(std::sin(angle) * distance, 0.42f * distance, std::cos(angle) * distance);
    return LookAt(target + offset, target);
  });
  return scene;
}

}  // namespace stillray
