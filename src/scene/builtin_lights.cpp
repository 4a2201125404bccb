// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// A room with moving light: a small lamp crosses it and casts shadows of a row of sliding slats on
/// wall and floor. The temporal history of its direct light quickly becomes invalid.
#include <cmath>
#include <string>

#include <fmt/format.h>

#include "scene/builtin.h"

namespace stillray {

namespace {

constexpr float kHalfWidth = 2.5f;
constexpr float kHeight = 2.8f;
constexpr float kBack = -2.4f;
constexpr float kFront = 2.8f;

void AddRoom(Scene* scene) {
  const int floor = AddTexturedMaterial(
      scene,
      MakePlanks("floor", 1024, 12, vec3(0.62f, 0.47f, 0.32f), vec3(0.30f, 0.19f, 0.11f), 31),
      0.5f);
  const int bricks = AddTexturedMaterial(
      scene,
      MakeBricks("bricks", 1024, 20, vec3(0.62f, 0.42f, 0.33f), vec3(0.66f, 0.63f, 0.58f), 41),
      0.9f);
  const int plaster = AddMaterial(scene, "plaster", vec3(0.78f, 0.76f, 0.72f), 0.0f, 1.0f);
  const vec3 size(2.0f * kHalfWidth, kHeight, kFront - kBack);
  constexpr float kFloorPerTexture = 2.2f;
  constexpr float kWallPerTexture = 2.0f;
  AddRoomSides(scene, vec3(-kHalfWidth, 0.0f, kBack), size,
               {.floor = {floor, vec2(size.z, size.x) / kFloorPerTexture},
                .ceiling = {plaster},
                .back = {bricks, vec2(size.x, size.y) / kWallPerTexture},
                .left = {bricks, vec2(size.z, size.y) / kWallPerTexture},
                .right = {plaster},
                .front = {plaster}});
}

void AddThings(Scene* scene) {
  const int clay = AddMaterial(scene, "clay", vec3(0.72f, 0.70f, 0.66f), 0.0f, 0.9f);
  const int blue = AddMaterial(scene, "blue glaze", vec3(0.08f, 0.20f, 0.45f), 0.0f, 0.15f);
  const int copper = AddMaterial(scene, "copper", vec3(0.93f, 0.60f, 0.46f), 1.0f, 0.3f);
  const int tiles =
      AddTexturedMaterial(scene,
                          MakeTiles("tiles", 512, 4, vec3(0.70f, 0.68f, 0.62f),
                                    vec3(0.20f, 0.35f, 0.33f), vec3(0.30f, 0.28f, 0.26f), 53),
                          0.4f);
  AddObject(scene, "pedestal", MakeBox(vec3(0.7f, 0.5f, 0.7f), 1.0f / 0.7f, tiles),
            vec3(1.25f, 0.0f, -1.35f));
  AddObject(scene, "glazed ball", MakeSphere(0.36f, 96, 48, blue), vec3(1.25f, 0.86f, -1.35f));
  AddObject(scene, "copper ball", MakeSphere(0.3f, 96, 48, copper), vec3(-0.35f, 0.3f, -0.1f));
  AddObject(scene, "pillar", MakeCylinder(0.16f, 1.5f, 64, vec2(1.0f), clay),
            vec3(-1.45f, 0.0f, -1.2f));
}

/// A dim panel under the ceiling, so that shadows are not black.
void AddFillLight(Scene* scene) {
  const int panel = AddLightMaterial(scene, "panel", vec3(0.55f, 0.65f, 0.80f));
  AddObject(scene, "panel",
            MakeQuad(vec3(-1.0f, kHeight - 0.002f, -0.5f), vec3(2.0f, 0.0f, 0.0f),
                     vec3(0.0f, 0.0f, 1.2f), vec2(1.0f), panel),
            vec3(0.0f));
}

void AddMovingLamp(Scene* scene) {
  const int glow = AddLightMaterial(scene, "lamp", vec3(900.0f, 730.0f, 500.0f));
  const int lamp = AddObject(scene, "lamp", MakeSphere(0.07f, 16, 8, glow), vec3(0.0f));
  Animate(scene, lamp, [](float t) {
    Transform pose;
    pose.translation =
        vec3(glm::mix(-1.1f, 1.1f, t), 2.3f + 0.2f * std::sin(3.14159265f * t), 0.55f);
    return pose;
  });
}

/// Upright slats under a rail, sliding in the opposite direction of the lamp.
void AddSlats(Scene* scene) {
  constexpr int kSlats = 6;
  constexpr float kGap = 0.24f;
  const int paint = AddMaterial(scene, "slats", vec3(0.16f, 0.11f, 0.08f), 0.0f, 0.6f);
  const int rail =
      AddObject(scene, "rail", MakeBox(vec3(kGap * kSlats, 0.05f, 0.05f), 1.0f, paint), vec3(0.0f));
  for (int i = 0; i < kSlats; ++i) {
    const float x = (static_cast<float>(i) - 0.5f * (kSlats - 1)) * kGap;
    const int slat =
        AddObject(scene, fmt::format("slat {}", i + 1),
                  MakeBox(vec3(0.12f, 1.35f, 0.02f), 1.0f, paint), vec3(x, -1.35f, 0.0f));
    scene->nodes[static_cast<size_t>(slat)].parent = rail;
  }
  Animate(scene, rail, [](float t) {
    Transform pose;
    pose.translation = vec3(glm::mix(0.35f, -0.35f, t), 2.0f, -0.75f);
    return pose;
  });
}

}  // namespace

Scene MakeLightsScene() {
  Scene scene;
  AddRoom(&scene);
  AddThings(&scene);
  AddFillLight(&scene);
  AddMovingLamp(&scene);
  AddSlats(&scene);
  constexpr float kFieldOfView = 0.80f;
  AddAnimatedCamera(&scene, kFieldOfView, [](float t) {
    const vec3 eye = glm::mix(vec3(0.55f, 1.45f, 2.65f), vec3(-0.25f, 1.35f, 2.3f), t);
    return LookAt(eye, vec3(0.0f, 1.05f, -1.2f));
  });
  return scene;
}

}  // namespace stillray
