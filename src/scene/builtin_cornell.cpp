// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The Cornell box with a moving short box and a wooden floor. Source: "Cornell Box Data", Cornell
/// University Program of Computer Graphics, 1998: dimensions in millimetres, here in metres; its x
/// axis runs to the left and its z axis away from the viewer, so both change sign. Walls are made
/// exactly rectangular (the real ones are off by up to 6 mm).
#include <cmath>
#include <utility>

#include "scene/builtin.h"

namespace stillray {

namespace {

constexpr float kHalfWidth = 0.2764f;
constexpr float kHeight = 0.5488f;
constexpr float kDepth = 0.5592f;

/// The measured reflectances, integrated to linear Rec. 709.
const vec3 kWhite(0.725f, 0.71f, 0.68f);
const vec3 kRed(0.63f, 0.065f, 0.05f);
const vec3 kGreen(0.14f, 0.45f, 0.091f);
/// Five times the lamp's measured emission, which integrates to (18.4, 14.0, 6.75) and gives a dim
/// image in a room with an open front.
const vec3 kLampRadiance(92.0f, 70.0f, 33.8f);

void AddRoom(Scene* scene) {
  const int white = AddMaterial(scene, "white", kWhite, 0.0f, 1.0f);
  const int red = AddMaterial(scene, "red", kRed, 0.0f, 1.0f);
  const int green = AddMaterial(scene, "green", kGreen, 0.0f, 1.0f);
  const int floor = AddTexturedMaterial(
      scene,
      MakePlanks("floor", 1024, 10, vec3(0.72f, 0.56f, 0.38f), vec3(0.38f, 0.25f, 0.14f), 11),
      0.55f);
  for (Material& material : scene->materials) {
    material.double_sided = true;
  }
  const vec3 x(2.0f * kHalfWidth, 0.0f, 0.0f);
  const vec3 y(0.0f, kHeight, 0.0f);
  const vec3 z(0.0f, 0.0f, kDepth);
  const vec3 corner(-kHalfWidth, 0.0f, -kDepth);
  const vec2 once(1.0f);
  const vec3 here(0.0f);
  AddObject(scene, "floor", MakeQuad(corner, z, x, once, floor), here);
  AddObject(scene, "ceiling", MakeQuad(corner + y, x, z, once, white), here);
  AddObject(scene, "back wall", MakeQuad(corner, x, y, once, white), here);
  AddObject(scene, "left wall", MakeQuad(corner, y, z, once, red), here);
  AddObject(scene, "right wall", MakeQuad(corner + x, z, y, once, green), here);
  const int tall = AddObject(scene, "tall box", MakeBox(vec3(0.165f, 0.330f, 0.165f), 1.0f, white),
                             vec3(-0.0905f, 0.0f, -0.3512f));
  scene->nodes[static_cast<size_t>(tall)].local.rotation = RotationY(0.3f);
}

void AddLamp(Scene* scene) {
  // 130 mm x 105 mm, slightly below the ceiling, so that the two do not coincide.
  constexpr float kGap = 0.0005f;
  const int lamp = AddLightMaterial(scene, "lamp", kLampRadiance);
  AddObject(scene, "lamp",
            MakeQuad(vec3(-0.065f, kHeight - kGap, -0.332f), vec3(0.130f, 0.0f, 0.0f),
                     vec3(0.0f, 0.0f, 0.105f), vec2(1.0f), lamp),
            vec3(0.0f));
}

/// The short box slides from beside the tall box to the front while rotating by 90 degrees.
void AddMovingBox(Scene* scene) {
  const int paint = AddMaterial(scene, "moving box", vec3(0.62f, 0.64f, 0.70f), 0.0f, 0.45f);
  const int box = AddObject(scene, "moving box", MakeBox(vec3(0.150f, 0.165f, 0.150f), 1.0f, paint),
                            vec3(0.0f));
  Animate(scene, box, [](float t) {
    const vec3 from(0.155f, 0.0f, -0.40f);
    const vec3 by(0.16f, 0.0f, -0.15f);
    const vec3 to(0.05f, 0.0f, -0.17f);
    Transform pose;
    pose.translation = glm::mix(glm::mix(from, by, t), glm::mix(by, to, t), t);
    pose.rotation = RotationY(-0.29f - 1.5707963f * t);
    return pose;
  });
}

}  // namespace

Scene MakeCornellScene() {
  Scene scene;
  AddRoom(&scene);
  AddLamp(&scene);
  AddMovingBox(&scene);
  // Closer than the original's 0.8 m, so that the box fills a wide image. Orbits the centre of the
  // room and moves closer.
  constexpr float kFieldOfView = 0.72f;
  AddAnimatedCamera(&scene, kFieldOfView, [](float t) {
    const vec3 target(0.0f, 0.215f, -0.28f);
    const float angle = glm::mix(-0.09f, 0.09f, t);
    const float distance = glm::mix(0.70f, 0.65f, t);
    const vec3 offset(std::sin(angle) * distance, 0.09f, std::cos(angle) * distance);
    return LookAt(target + offset, target);
  });
  return scene;
}

}  // namespace stillray
