// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Thin moving objects before a brick wall: wires, a gate of wire mesh, grass in a pot and cloth
/// with folds. Many are narrower than a pixel, and disocclude the background in every frame.
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "core/random.h"
#include "scene/builtin.h"

namespace stillray {

namespace {

constexpr float kPi = 3.14159265f;
constexpr float kWall = -0.9f;
const vec3 kAxisX(1.0f, 0.0f, 0.0f);
const vec3 kAxisY(0.0f, 1.0f, 0.0f);

/// Deterministic random number in 0..1, a hash of the arguments.
float Chance(int index, uint32_t purpose) {
  return UniformFloat(HashCombine(purpose, static_cast<uint32_t>(index)));
}

void AddYard(Scene* scene) {
  const int ground = AddTexturedMaterial(
      scene,
      MakePlanks("deck", 1024, 12, vec3(0.56f, 0.47f, 0.37f), vec3(0.28f, 0.21f, 0.15f), 101),
      0.6f);
  const int bricks = AddTexturedMaterial(
      scene,
      MakeBricks("bricks", 1024, 20, vec3(0.60f, 0.40f, 0.32f), vec3(0.68f, 0.65f, 0.60f), 103),
      0.9f);
  const vec3 x(8.0f, 0.0f, 0.0f);
  const vec3 y(0.0f, 3.2f, 0.0f);
  const vec3 z(0.0f, 0.0f, 4.4f);
  const vec3 corner(-0.5f * x.x, 0.0f, kWall);
  constexpr float kDeckPerTexture = 2.0f;
  constexpr float kWallPerTexture = 1.6f;
  AddObject(scene, "deck", MakeQuad(corner, z, x, vec2(z.z, x.x) / kDeckPerTexture, ground),
            vec3(0.0f));
  AddObject(scene, "wall", MakeQuad(corner, x, y, vec2(x.x, y.y) / kWallPerTexture, bricks),
            vec3(0.0f));
}

/// Adds a diffuse sky, and a panel above the camera's left that casts shadows.
void AddLight(Scene* scene) {
  scene->environment.radiance = vec3(0.42f, 0.50f, 0.60f);
  const int panel = AddLightMaterial(scene, "panel", vec3(52.0f, 45.0f, 34.0f));
  AddObject(scene, "panel",
            MakeQuad(vec3(-1.2f, 3.0f, 2.6f), vec3(-1.0f, 0.0f, 0.0f), vec3(0.0f, 0.6f, -0.8f),
                     vec2(1.0f), panel),
            vec3(0.0f));
}

/// A wire from `from` to `to` that hangs down by `sag` in its middle.
Mesh MakeWire(vec3 from, vec3 to, float sag, float radius, int material) {
  constexpr int kSides = 10;
  const int segments = sag > 0.0f ? 48 : 1;
  return MakeTube(
      [=](float t) { return glm::mix(from, to, t) - kAxisY * (4.0f * sag * t * (1.0f - t)); },
      radius, kSides, segments, material);
}

/// Animates a node at `place` to swing about an axis: `swings` times to +-`radians`.
void Swing(Scene* scene, int node, vec3 place, vec3 axis, float radians, float swings,
           float phase) {
  Animate(scene, node, [=](float t) {
    Transform pose;
    pose.translation = place;
    pose.rotation = RotationAbout(axis, radians * std::sin(2.0f * kPi * (swings * t + phase)));
    return pose;
  });
}

/// A cloth that hangs down from y = 0; its folds become deeper towards the lower edge.
Mesh MakeCloth(vec2 size, int material) {
  constexpr float kFolds = 5.0f;
  constexpr float kDepth = 0.065f;
  return MakePatch(
      160, 64,
      [=](float u, float v) {
        const float along = 2.0f * kPi * (kFolds * u + 0.1f * std::sin(2.0f * kPi * v));
        const float fold = std::sin(along) + 0.35f * std::sin(0.5f * along + 2.0f * v);
        return vec3((u - 0.5f) * size.x, (v - 1.0f) * size.y, kDepth * (1.15f - 0.85f * v) * fold);
      },
      size / 0.6f, material);
}

/// Cloth that swings about a line.
void AddClothOnLine(Scene* scene, int steel) {
  const vec2 size(1.15f, 0.95f);
  const vec3 place(0.75f, 1.62f, -0.25f);
  const int fabric =
      AddTexturedMaterial(scene,
                          MakeTiles("fabric", 512, 8, vec3(0.80f, 0.76f, 0.66f),
                                    vec3(0.16f, 0.30f, 0.52f), vec3(0.62f, 0.58f, 0.50f), 107),
                          0.9f);
  scene->materials.back().double_sided = true;
  AddObject(scene, "line",
            MakeWire(vec3(-4.0f, 1.62f, -0.25f), vec3(4.0f, 1.62f, -0.25f), 0.0f, 0.004f, steel),
            vec3(0.0f));
  const int cloth = AddObject(scene, "cloth", MakeCloth(size, fabric), place);
  Swing(scene, cloth, place, kAxisX, 0.16f, 1.5f, 0.0f);
}

/// Adds wires across the image that swing about the line through their ends.
void AddWires(Scene* scene, int steel) {
  constexpr int kWires = 4;
  for (int i = 0; i < kWires; ++i) {
    const float step = static_cast<float>(i);
    const vec3 place(0.0f, 2.02f - 0.09f * step, 0.1f - 0.16f * step);
    const float half = 3.2f;
    const float radius = i % 2 == 0 ? 0.0025f : 0.0045f;
    const std::string name = fmt::format("wire {}", i + 1);
    const int wire = AddObject(
        scene, name,
        MakeWire(vec3(-half, 0.0f, 0.0f), vec3(half, 0.02f * step, 0.0f), 0.16f, radius, steel),
        place);
    Swing(scene, wire, place, kAxisX, 0.35f, 2.0f, 0.21f * step);
  }
}

/// Upright bars and thinner wires across, in the xy plane to the right of the node's y axis.
void AddWireMesh(Scene* scene, vec2 size, int gate, int steel) {
  constexpr int kBars = 13;
  constexpr int kWires = 12;
  for (int i = 0; i < kBars; ++i) {
    const float x = size.x * static_cast<float>(i) / (kBars - 1);
    AddChild(scene, fmt::format("bar {}", i + 1),
             MakeWire(vec3(x, 0.0f, 0.0f), vec3(x, size.y, 0.0f), 0.0f, 0.006f, steel), vec3(0.0f),
             gate);
  }
  for (int i = 0; i < kWires; ++i) {
    const float y = size.y * (static_cast<float>(i) + 0.5f) / kWires;
    AddChild(scene, fmt::format("mesh wire {}", i + 1),
             MakeWire(vec3(0.0f, y, 0.0f), vec3(size.x, y, 0.0f), 0.0f, 0.0015f, steel), vec3(0.0f),
             gate);
  }
}

/// A gate of wire mesh that opens about its left edge.
void AddGate(Scene* scene, int steel) {
  const vec2 size(1.1f, 1.15f);
  constexpr float kBar = 0.03f;
  const int gate = AddNode(scene, "gate", vec3(0.0f));
  const Mesh rail = MakeBox(vec3(size.x + kBar, kBar, kBar), 1.0f, steel);
  for (const float y : {0.0f, size.y}) {
    AddChild(scene, "rail", rail, vec3(0.5f * size.x, y, 0.0f), gate);
  }
  AddWireMesh(scene, size, gate, steel);
  Animate(scene, gate, [](float t) {
    Transform pose;
    pose.translation = vec3(-1.6f, 0.06f, -0.3f);
    pose.rotation = RotationY(glm::mix(0.15f, -0.45f, t));
    return pose;
  });
}

/// A blade of grass from the origin that bends over in direction `azimuth`.
Mesh MakeBlade(float length, float bend, float azimuth, int material) {
  constexpr float kHalfWidth = 0.006f;
  const vec3 outward(std::sin(azimuth), 0.0f, std::cos(azimuth));
  const vec3 side(std::cos(azimuth), 0.0f, -std::sin(azimuth));
  return MakePatch(
      2, 14,
      [=](float u, float v) {
        // A tip of zero width has no normal.
        const float width = kHalfWidth * std::max(1.0f - v * v, 0.08f);
        const vec3 centre =
            length * (std::sin(bend * v) * outward + std::cos(bend * v) * v * kAxisY);
        return centre + side * (width * (2.0f * u - 1.0f));
      },
      vec2(1.0f), material);
}

/// A tuft of blades that sway together.
Mesh MakeTuft(int tuft, int blades, int material) {
  Mesh mesh;
  mesh.material = material;
  for (int i = 0; i < blades; ++i) {
    const int index = tuft * blades + i;
    const float azimuth = 2.0f * kPi * Chance(index, 1);
    const float from_axis = 0.13f * std::sqrt(Chance(index, 2));
    const vec3 root(from_axis * std::sin(azimuth), 0.0f, from_axis * std::cos(azimuth));
    const float length = glm::mix(0.45f, 0.80f, Chance(index, 3));
    const float bend = glm::mix(0.15f, 0.80f, Chance(index, 4));
    AppendMesh(&mesh, MakeBlade(length, bend, azimuth, material), root);
  }
  return mesh;
}

void AddGrass(Scene* scene) {
  constexpr int kTufts = 5;
  constexpr int kBlades = 26;
  constexpr float kPotHeight = 0.32f;
  const vec3 place(-0.1f, 0.0f, 0.25f);
  const int clay = AddMaterial(scene, "clay", vec3(0.58f, 0.34f, 0.24f), 0.0f, 0.8f);
  AddObject(scene, "pot", MakeCylinder(0.17f, kPotHeight, 64, vec2(1.0f), clay), place);
  for (int i = 0; i < kTufts; ++i) {
    const float shade = static_cast<float>(i) / (kTufts - 1);
    const std::string name = fmt::format("tuft {}", i + 1);
    const int green = AddMaterial(
        scene, name, glm::mix(vec3(0.14f, 0.34f, 0.08f), vec3(0.50f, 0.54f, 0.18f), shade), 0.0f,
        0.6f);
    scene->materials.back().double_sided = true;
    const vec3 root = place + kPotHeight * kAxisY;
    const int tuft = AddObject(scene, name, MakeTuft(i, kBlades, green), root);
    const vec3 axis(std::cos(0.5f * shade), 0.0f, std::sin(0.5f * shade) - 1.0f);
    Swing(scene, tuft, root, glm::normalize(axis), 0.09f, 2.0f, 0.17f * static_cast<float>(i));
  }
}

}  // namespace

Scene MakeThinScene() {
  Scene scene;
  AddYard(&scene);
  AddLight(&scene);
  const int steel = AddMaterial(&scene, "steel", vec3(0.34f, 0.35f, 0.36f), 1.0f, 0.4f);
  AddClothOnLine(&scene, steel);
  AddWires(&scene, steel);
  AddGate(&scene, steel);
  AddGrass(&scene);
  constexpr float kFieldOfView = 0.66f;
  AddAnimatedCamera(&scene, kFieldOfView, [](float t) {
    const vec3 eye = glm::mix(vec3(0.3f, 1.25f, 3.3f), vec3(-0.2f, 1.15f, 3.1f), t);
    return LookAt(eye, vec3(0.0f, 0.92f, -0.3f));
  });
  return scene;
}

}  // namespace stillray
