// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// A room with two finely displaced objects, one that spins and one that orbits a mirror sphere,
/// under a ceiling light and a lamp that moves. It is named after a scene of the PSVGF paper and
/// has equivalent contents; all shapes are original.
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "scene/builtin.h"

namespace stillray {

namespace {

constexpr float kPi = 3.14159265f;
constexpr float kHalfWidth = 2.6f;
constexpr float kHeight = 2.9f;
constexpr float kBack = -2.6f;
constexpr float kFront = 3.1f;

void AddRoom(Scene* scene) {
  const int floor =
      AddTexturedMaterial(scene,
                          MakeTiles("floor", 1024, 8, vec3(0.62f, 0.60f, 0.56f),
                                    vec3(0.26f, 0.25f, 0.26f), vec3(0.16f, 0.15f, 0.14f), 131),
                          0.35f);
  const int panels = AddTexturedMaterial(
      scene,
      MakePlanks("panels", 1024, 10, vec3(0.58f, 0.44f, 0.30f), vec3(0.30f, 0.19f, 0.12f), 137),
      0.5f);
  const int plaster = AddTexturedMaterial(
      scene,
      MakeMottled("plaster", 512, 4, vec3(0.66f, 0.66f, 0.63f), vec3(0.54f, 0.55f, 0.55f), 139),
      0.9f);
  const int teal =
      AddTexturedMaterial(scene,
                          MakeMottled("teal plaster", 512, 4, vec3(0.16f, 0.38f, 0.40f),
                                      vec3(0.10f, 0.28f, 0.31f), 149),
                          0.9f);
  const int red = AddTexturedMaterial(
      scene,
      MakeMottled("red plaster", 512, 4, vec3(0.56f, 0.17f, 0.12f), vec3(0.44f, 0.11f, 0.08f), 151),
      0.9f);
  const vec3 size(2.0f * kHalfWidth, kHeight, kFront - kBack);
  constexpr float kPerTexture = 2.6f;
  const vec2 side(vec2(size.z, size.y) / kPerTexture);
  const vec2 across(vec2(size.x, size.y) / kPerTexture);
  const vec2 flat(vec2(size.z, size.x) / kPerTexture);
  AddRoomSides(scene, vec3(-kHalfWidth, 0.0f, kBack), size,
               {.floor = {floor, flat},
                .ceiling = {plaster, vec2(flat.y, flat.x)},
                .back = {panels, across},
                .left = {red, side},
                .right = {teal, side},
                .front = {plaster, across}});
}

/// Points spread evenly over the unit sphere, on a spiral.
std::vector<vec3> SpiralPoints(int count) {
  constexpr float kGoldenAngle = 2.39996323f;
  std::vector<vec3> points;
  for (int i = 0; i < count; ++i) {
    const float y = 1.0f - 2.0f * (static_cast<float>(i) + 0.5f) / static_cast<float>(count);
    const float ring = std::sqrt(1.0f - y * y);
    const float angle = kGoldenAngle * static_cast<float>(i);
    points.emplace_back(ring * std::sin(angle), y, ring * std::cos(angle));
  }
  return points;
}

/// A ball carved with a knob around each point, with rings about it.
class CarvedBall {
 public:
  CarvedBall(float radius, int knobs) : radius_(radius), points_(SpiralPoints(knobs)) {}

  vec3 operator()(vec3 direction) const {
    // Adjacent knobs are blended: a crease would alias.
    constexpr float kSharpness = 40.0f;
    constexpr float kReach = 0.62f;  // beyond this distance the term is below 1e-6
    constexpr float kRings = 17.0f;
    float weight = 0.0f;
    float rings = 0.0f;
    for (const vec3& point : points_) {
      const vec3 between = direction - point;
      const float distance2 = glm::dot(between, between);
      if (distance2 < kReach * kReach) {
        const float term = std::exp(-kSharpness * distance2);
        weight += term;
        rings += term * std::cos(2.0f * kPi * kRings * std::sqrt(distance2 + 1e-4f));
      }
    }
    constexpr float kKnob = 0.023f;
    constexpr float kRing = 0.0011f;
    const float height = kKnob * std::log(weight) + kRing * rings / weight;
    // Taller than wide.
    return (radius_ + height * radius_ / 0.4f) * direction * vec3(1.0f, 1.22f, 1.0f);
  }

 private:
  float radius_;
  std::vector<vec3> points_;
};

/// A cube whose faces are projected onto the sphere: cells of nearly the same size everywhere.
Mesh MakeCarvedBall(int cells, int material) {
  const CarvedBall surface(0.44f, 110);
  struct Face {
    vec3 normal;
    vec3 u;
  };
  const std::array<Face, 6> faces = {{
      {vec3(1, 0, 0), vec3(0, 1, 0)},
      {vec3(-1, 0, 0), vec3(0, 0, 1)},
      {vec3(0, 1, 0), vec3(0, 0, 1)},
      {vec3(0, -1, 0), vec3(1, 0, 0)},
      {vec3(0, 0, 1), vec3(1, 0, 0)},
      {vec3(0, 0, -1), vec3(0, 1, 0)},
  }};
  Mesh mesh;
  mesh.material = material;
  for (const Face& face : faces) {
    const vec3 v_axis = glm::cross(face.normal, face.u);
    const auto point = [&](float u, float v) {
      // Equal angles, so that cells near the edges are not smaller.
      const float a = std::tan(0.5f * kPi * (u - 0.5f));
      const float b = std::tan(0.5f * kPi * (v - 0.5f));
      return surface(glm::normalize(face.normal + a * face.u + b * v_axis));
    };
    AppendMesh(&mesh, MakePatch(cells, cells, point, vec2(1.0f), material), vec3(0.0f));
  }
  return mesh;
}

/// A (2, 3) torus knot of rope.
vec3 KnotCentre(float t) {
  constexpr float kRing = 0.26f;
  constexpr float kTube = 0.115f;
  const float around = 4.0f * kPi * t;
  const float through = 6.0f * kPi * t;
  const float from_axis = kRing + kTube * std::cos(through);
  return {from_axis * std::cos(around), kTube * std::sin(through), from_axis * std::sin(around)};
}

vec3 KnotSurface(float u, float t) {
  constexpr float kStep = 1.0f / 2048.0f;
  constexpr float kRadius = 0.066f;
  constexpr float kStrand = 0.125f;
  constexpr float kStrands = 4.0f;
  constexpr float kTwist = 40.0f;  // an integer, so that the rope closes
  const vec3 centre = KnotCentre(t);
  const vec3 along = glm::normalize(KnotCentre(t + kStep) - KnotCentre(t - kStep));
  // The ring around which the knot winds gives a frame that closes with the knot.
  const vec3 ring = 0.26f * glm::normalize(vec3(centre.x, 0.0f, centre.z));
  const vec3 side = glm::normalize(glm::cross(along, centre - ring));
  const vec3 up = glm::cross(along, side);
  const float angle = 2.0f * kPi * u;
  const float strand = std::cos(kStrands * angle + 2.0f * kPi * kTwist * t);
  const float radius = kRadius * (1.0f + kStrand * strand);
  return centre + radius * (std::cos(angle) * side + std::sin(angle) * up);
}

Mesh MakeKnot(int sides, int segments, int material) {
  constexpr int kParts = 4;  // MakePatch takes differences over a part of a patch
  Mesh mesh;
  mesh.material = material;
  for (int part = 0; part < kParts; ++part) {
    const auto point = [&](float u, float v) {
      return KnotSurface(u, (static_cast<float>(part) + v) / kParts);
    };
    AppendMesh(&mesh, MakePatch(sides, segments / kParts, point, vec2(1.0f), material), vec3(0.0f));
  }
  return mesh;
}

/// A foot, a narrow stem and a plate on which something stands.
Mesh MakePedestal(int material) {
  const std::vector<vec2> curve = {
      {0.30f, 0.0f},   {0.30f, 0.05f},  {0.285f, 0.07f}, {0.24f, 0.085f},
      {0.17f, 0.12f},  {0.135f, 0.18f}, {0.12f, 0.26f},  {0.115f, 0.34f},
      {0.125f, 0.41f}, {0.16f, 0.46f},  {0.23f, 0.485f}, {0.27f, 0.50f},
      {0.28f, 0.52f},  {0.28f, 0.55f},  {0.27f, 0.56f},  {0.0f, 0.56f}};
  return MakeLathe(curve, 96, vec2(1.0f), material);
}

void AddSpinningBall(Scene* scene) {
  const int stone = AddMaterial(scene, "stone", vec3(0.50f, 0.48f, 0.45f), 0.0f, 0.5f);
  const int glaze = AddMaterial(scene, "glaze", vec3(0.72f, 0.60f, 0.40f), 0.0f, 0.3f);
  const vec3 place(-1.3f, 0.0f, -0.95f);
  AddObject(scene, "pedestal", MakePedestal(stone), place);
  const int ball = AddObject(scene, "spinning ball", MakeCarvedBall(115, glaze), vec3(0.0f));
  Animate(scene, ball, [=](float t) {
    Transform pose;
    pose.translation = place + vec3(0.0f, 1.11f, 0.0f);
    pose.rotation = RotationY(2.0f * kPi * t);
    return pose;
  });
}

/// Adds a knot that orbits the mirror sphere while it rotates.
void AddOrbitingKnot(Scene* scene, vec3 centre) {
  const int gold = AddMaterial(scene, "gold", vec3(0.95f, 0.70f, 0.36f), 1.0f, 0.28f);
  const int knot = AddObject(scene, "orbiting knot", MakeKnot(80, 1000, gold), vec3(0.0f));
  Animate(scene, knot, [=](float t) {
    constexpr float kOrbit = 0.8f;
    const float angle = glm::mix(-0.42f * kPi, 0.62f * kPi, t);
    Transform pose;
    pose.translation =
        centre + vec3(kOrbit * std::sin(angle), 0.72f + 0.2f * std::cos(angle - 0.6f),
                      kOrbit * std::cos(angle));
    pose.rotation = RotationAbout(glm::normalize(vec3(0.7f, 0.5f, 0.3f)), 0.6f + 2.5f * t);
    return pose;
  });
}

void AddLights(Scene* scene) {
  const int panel = AddLightMaterial(scene, "ceiling light", vec3(7.0f, 6.6f, 6.0f));
  AddObject(scene, "ceiling light",
            MakeQuad(vec3(-0.9f, kHeight - 0.002f, -1.1f), vec3(1.8f, 0.0f, 0.0f),
                     vec3(0.0f, 0.0f, 1.3f), vec2(1.0f), panel),
            vec3(0.0f));
  const int glow = AddLightMaterial(scene, "moving light", vec3(170.0f, 120.0f, 70.0f));
  const int lamp = AddObject(scene, "moving light", MakeSphere(0.08f, 32, 16, glow), vec3(0.0f));
  Animate(scene, lamp, [](float t) {
    Transform pose;
    pose.translation =
        vec3(glm::mix(1.9f, -1.5f, t), 2.05f + 0.25f * std::sin(kPi * t), glm::mix(-1.6f, 0.6f, t));
    return pose;
  });
}

}  // namespace

Scene MakeFaustScene() {
  Scene scene;
  AddRoom(&scene);
  AddLights(&scene);
  AddSpinningBall(&scene);
  const int chrome = AddMaterial(&scene, "mirror sphere", vec3(0.92f, 0.92f, 0.93f), 1.0f, 0.0f);
  constexpr float kMirrorRadius = 0.42f;
  const vec3 mirror(0.55f, kMirrorRadius, -0.75f);
  AddObject(&scene, "mirror sphere", MakeSphere(kMirrorRadius, 144, 66, chrome), mirror);
  AddOrbitingKnot(&scene, mirror);
  constexpr float kFieldOfView = 0.70f;
  AddAnimatedCamera(&scene, kFieldOfView, [](float t) {
    const vec3 eye = glm::mix(vec3(-0.35f, 1.45f, 2.95f), vec3(0.15f, 1.55f, 2.80f), t);
    return LookAt(eye, vec3(0.05f, 0.92f, -0.8f));
  });
  return scene;
}

}  // namespace stillray
