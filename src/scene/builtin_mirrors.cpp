// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// A room whose textures are visible in a rotating wall mirror, in chrome, through glass and
/// through a window pane. A crate slides past all of them: the motion of its virtual images differs
/// from that of the reflecting surfaces.
#include <string>
#include <utility>

#include "scene/builtin.h"

namespace stillray {

namespace {

constexpr float kHalfWidth = 2.5f;
constexpr float kHeight = 2.8f;
constexpr float kBack = -2.3f;
constexpr float kFront = 3.0f;

/// Every wall has its own texture, so that all reflections have detail.
void AddRoom(Scene* scene) {
  const int floor =
      AddTexturedMaterial(scene,
                          MakeTiles("floor", 1024, 8, vec3(0.64f, 0.58f, 0.48f),
                                    vec3(0.34f, 0.38f, 0.42f), vec3(0.20f, 0.18f, 0.16f), 61),
                          0.55f);
  const int bricks = AddTexturedMaterial(
      scene,
      MakeBricks("bricks", 1024, 20, vec3(0.62f, 0.40f, 0.30f), vec3(0.66f, 0.63f, 0.58f), 67),
      0.9f);
  const int pale_bricks = AddTexturedMaterial(
      scene,
      MakeBricks("pale bricks", 1024, 14, vec3(0.52f, 0.58f, 0.60f), vec3(0.30f, 0.30f, 0.31f), 71),
      0.9f);
  const int panels = AddTexturedMaterial(
      scene,
      MakePlanks("panels", 1024, 10, vec3(0.66f, 0.52f, 0.36f), vec3(0.34f, 0.23f, 0.14f), 73),
      0.6f);
  const int plaster = AddMaterial(scene, "plaster", vec3(0.78f, 0.76f, 0.72f), 0.0f, 1.0f);
  const vec3 size(2.0f * kHalfWidth, kHeight, kFront - kBack);
  constexpr float kFloorPerTexture = 2.4f;
  constexpr float kWallPerTexture = 2.0f;
  const vec2 side(vec2(size.z, size.y) / kWallPerTexture);
  const vec2 across(vec2(size.x, size.y) / kWallPerTexture);
  AddRoomSides(scene, vec3(-kHalfWidth, 0.0f, kBack), size,
               {.floor = {floor, vec2(size.z, size.x) / kFloorPerTexture},
                .ceiling = {plaster},
                .back = {pale_bricks, across},
                .left = {panels, side},
                .right = {bricks, side},
                .front = {bricks, across}});
}

/// Adds ceiling panels: large and therefore dim, so that a single light sample has little noise and
/// reflections of the panels keep their colour.
void AddPanels(Scene* scene) {
  const int warm = AddLightMaterial(scene, "warm panel", vec3(5.2f, 4.5f, 3.5f));
  const int cool = AddLightMaterial(scene, "cool panel", vec3(2.9f, 3.4f, 4.1f));
  const vec3 x(1.4f, 0.0f, 0.0f);
  const vec3 z(0.0f, 0.0f, 2.5f);
  constexpr float kGap = 0.002f;
  const float y = kHeight - kGap;
  AddObject(scene, "warm panel", MakeQuad(vec3(-2.0f, y, -1.5f), x, z, vec2(1.0f), warm),
            vec3(0.0f));
  AddObject(scene, "cool panel", MakeQuad(vec3(0.6f, y, -1.5f), x, z, vec2(1.0f), cool),
            vec3(0.0f));
}

/// Four bars around a width x height opening about the node's origin, in its xy plane.
void AddFrame(Scene* scene, const std::string& name, vec2 opening, float bar, int material,
              int parent) {
  const vec2 half = 0.5f * opening;
  const Mesh across = MakeBox(vec3(opening.x + 2.0f * bar, bar, bar), 1.0f, material);
  const Mesh upright = MakeBox(vec3(bar, opening.y, bar), 1.0f, material);
  AddChild(scene, name + ", top", across, vec3(0.0f, half.y, 0.0f), parent);
  AddChild(scene, name + ", bottom", across, vec3(0.0f, -half.y - bar, 0.0f), parent);
  AddChild(scene, name + ", left", upright, vec3(-half.x - 0.5f * bar, -half.y, 0.0f), parent);
  AddChild(scene, name + ", right", upright, vec3(half.x + 0.5f * bar, -half.y, 0.0f), parent);
}

Mesh MakePane(vec2 size, int material) {
  return MakeQuad(vec3(-0.5f * size, 0.0f), vec3(size.x, 0.0f, 0.0f), vec3(0.0f, size.y, 0.0f),
                  vec2(1.0f), material);
}

/// Adds a mirror that rotates about its vertical axis, at a distance from the back wall that
/// permits a rotation by kTurn.
void AddMirror(Scene* scene, int wood) {
  const vec2 size(2.9f, 2.0f);
  constexpr float kBar = 0.06f;
  constexpr float kTurn = 0.1f;  // radians to either side
  const int silver = AddMaterial(scene, "mirror", vec3(0.94f, 0.95f, 0.94f), 1.0f, 0.0f);
  const int mirror = AddNode(scene, "mirror", vec3(0.0f));
  AddChild(scene, "mirror pane", MakePane(size, silver), vec3(0.0f), mirror);
  AddChild(scene, "mirror board", MakeBox(vec3(size, 0.02f), 1.0f, wood),
           vec3(0.0f, -0.5f * size.y, -0.012f), mirror);
  AddFrame(scene, "mirror frame", size, kBar, wood, mirror);
  Animate(scene, mirror, [](float t) {
    Transform pose;
    pose.translation = vec3(-0.5f, 1.20f, kBack + 0.22f);
    pose.rotation = RotationY(glm::mix(-kTurn, kTurn, t));
    return pose;
  });
}

/// A thin pane of glass in a frame that stands in the room, with a textured pedestal behind it.
void AddWindow(Scene* scene, int wood) {
  const vec2 size(1.05f, 1.25f);
  constexpr float kBar = 0.05f;
  const int glass = AddMaterial(scene, "window pane", vec3(1.0f), 0.0f, 0.0f);
  scene->materials.back().transmission = 1.0f;
  scene->materials.back().double_sided = true;
  const int window = AddNode(scene, "window", vec3(1.3f, 0.5f * size.y + kBar, 0.05f));
  scene->nodes[static_cast<size_t>(window)].local.rotation = RotationY(-0.3f);
  AddChild(scene, "window pane", MakePane(size, glass), vec3(0.0f), window);
  AddFrame(scene, "window frame", size, kBar, wood, window);
}

void AddThings(Scene* scene) {
  const int chrome = AddMaterial(scene, "chrome", vec3(0.90f, 0.91f, 0.92f), 1.0f, 0.0f);
  const int copper = AddMaterial(scene, "rough copper", vec3(0.93f, 0.60f, 0.46f), 1.0f, 0.35f);
  const int glass = AddMaterial(scene, "glass", vec3(1.0f), 0.0f, 0.0f);
  scene->materials.back().transmission = 1.0f;
  scene->materials.back().solid = true;
  const int tiles =
      AddTexturedMaterial(scene,
                          MakeTiles("tiles", 512, 4, vec3(0.72f, 0.68f, 0.58f),
                                    vec3(0.55f, 0.18f, 0.14f), vec3(0.30f, 0.28f, 0.26f), 79),
                          0.4f);
  AddObject(scene, "chrome ball", MakeSphere(0.36f, 128, 64, chrome), vec3(0.62f, 0.36f, -1.35f));
  AddObject(scene, "glass ball", MakeSphere(0.3f, 128, 64, glass), vec3(-0.85f, 0.3f, -0.08f));
  AddObject(scene, "copper drum", MakeCylinder(0.24f, 0.62f, 96, vec2(1.0f), copper),
            vec3(-0.3f, 0.0f, -1.45f));
  AddObject(scene, "pedestal", MakeBox(vec3(0.55f, 0.8f, 0.55f), 1.0f / 0.55f, tiles),
            vec3(1.95f, 0.0f, -1.05f));
}

/// Adds a crate that slides from the left, behind the glass ball, to behind the window while
/// rotating by 90 degrees.
void AddCrate(Scene* scene) {
  constexpr float kSide = 0.42f;
  const int wood = AddTexturedMaterial(
      scene, MakePlanks("crate", 512, 4, vec3(0.30f, 0.56f, 0.40f), vec3(0.10f, 0.22f, 0.16f), 83),
      0.5f);
  const int crate = AddObject(scene, "crate", MakeBox(vec3(kSide), 1.0f / kSide, wood), vec3(0.0f));
  Animate(scene, crate, [](float t) {
    const vec3 from(-1.45f, 0.0f, -0.75f);
    const vec3 to(1.3f, 0.0f, -0.5f);
    Transform pose;
    pose.translation = glm::mix(from, to, t);
    pose.rotation = RotationY(0.4f + 1.5707963f * t);
    return pose;
  });
}

}  // namespace

Scene MakeMirrorsScene() {
  Scene scene;
  AddRoom(&scene);
  AddPanels(&scene);
  const int wood = AddTexturedMaterial(
      &scene,
      MakePlanks("frames", 512, 8, vec3(0.46f, 0.30f, 0.18f), vec3(0.20f, 0.12f, 0.07f), 89), 0.4f);
  AddMirror(&scene, wood);
  AddWindow(&scene, wood);
  AddThings(&scene);
  AddCrate(&scene);
  constexpr float kFieldOfView = 0.72f;
  AddAnimatedCamera(&scene, kFieldOfView, [](float t) {
    const vec3 eye = glm::mix(vec3(0.35f, 1.55f, 2.75f), vec3(-0.15f, 1.45f, 2.5f), t);
    return LookAt(eye, vec3(0.1f, 0.82f, -1.2f));
  });
  return scene;
}

}  // namespace stillray
