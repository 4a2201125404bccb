// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "motion/moving_scene.h"

#include <cmath>

namespace stillray {
namespace {

constexpr float kWallDepth = 10;
constexpr float kBoxDepth = 5;
constexpr float kHalfBox = 22;  // pixels

/// Random numbers on a lattice, between which it is interpolated.
float Lattice(int x, int y, uint32_t seed) {
  uint32_t h = static_cast<uint32_t>(x) * 73856093u ^ static_cast<uint32_t>(y) * 19349663u ^
               seed * 83492791u;
  h = (h ^ (h >> 13)) * 1274126177u;
  return static_cast<float>((h ^ (h >> 16)) & 0xffff) / 65535.0f;
}

float Noise(vec2 p, float size, uint32_t seed) {
  const vec2 q = p / size;
  const int x = static_cast<int>(std::floor(q.x));
  const int y = static_cast<int>(std::floor(q.y));
  const float u = q.x - std::floor(q.x);
  const float v = q.y - std::floor(q.y);
  const float top = Lattice(x, y, seed) * (1 - u) + Lattice(x + 1, y, seed) * u;
  const float bottom = Lattice(x, y + 1, seed) * (1 - u) + Lattice(x + 1, y + 1, seed) * u;
  return top * (1 - v) + bottom * v;
}

vec3 Texture(vec2 p, uint32_t seed) {
  return {0.2f + 0.6f * Noise(p, 9, seed), 0.2f + 0.6f * Noise(p, 5, seed + 1),
          Noise(p, 14, seed + 2) > 0.5f ? 0.7f : 0.3f};
}

}  // namespace

/// The place on the box of a place in the picture.
vec2 MovingScene::InBox(vec2 p, float frame) const {
  const vec2 middle = vec2(0.45f * static_cast<float>(width), 0.5f * static_cast<float>(height)) +
                      frame * box_speed;
  const float c = std::cos(box_turn * frame);
  const float s = std::sin(box_turn * frame);
  const vec2 q = p - middle;
  return {c * q.x + s * q.y, c * q.y - s * q.x};
}

bool MovingScene::ShowsBox(int x, int y, float frame) const {
  const vec2 q = InBox(vec2(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f), frame);
  return box && std::fabs(q.x) < kHalfBox && std::fabs(q.y) < kHalfBox;
}

Guides MovingScene::At(float frame, vec2 jitter) const {
  Guides g;
  g.depth = Image1(width, height);
  g.normal = Image3(width, height);
  g.albedo = Image3(width, height);
  if (ids) {
    g.id = Plane<uint32_t>(width, height);
  }
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const vec2 p = vec2(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f) + jitter;
      const vec2 q = InBox(p, frame);
      const bool on_box = box && std::fabs(q.x) < kHalfBox && std::fabs(q.y) < kHalfBox;
      const bool plain = !on_box && !textured;
      const vec3 albedo =
          plain ? vec3(0.4f)
                : Texture(on_box ? q : p - frame * wall_speed, on_box ? seed + 10 : seed);
      for (int c = 0; c < 3; ++c) {
        g.albedo[c](x, y) = albedo[c];
      }
      g.normal[2](x, y) = 1;
      g.depth(x, y) = on_box ? kBoxDepth : kWallDepth;
      if (ids) {
        g.id(x, y) = on_box ? 2 : 1;
      }
    }
  }
  return g;
}

vec2 MovingScene::TrueMotion(int x, int y, float frame) const {
  if (!ShowsBox(x, y, frame)) {
    return -wall_speed;
  }
  const vec2 p(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f);
  const vec2 q = InBox(p, frame);
  const float angle = box_turn * (frame - 1);
  const vec2 turned = {std::cos(angle) * q.x - std::sin(angle) * q.y,
                       std::sin(angle) * q.x + std::cos(angle) * q.y};
  const vec2 middle = p - vec2(std::cos(box_turn * frame) * q.x - std::sin(box_turn * frame) * q.y,
                               std::sin(box_turn * frame) * q.x + std::cos(box_turn * frame) * q.y);
  return middle - box_speed + turned - p;
}

bool MovingScene::WasSeen(int x, int y, float frame) const {
  const vec2 motion = TrueMotion(x, y, frame);
  const int u = x + static_cast<int>(std::lround(motion.x));
  const int v = y + static_cast<int>(std::lround(motion.y));
  return u >= 1 && v >= 1 && u < width - 1 && v < height - 1 &&
         ShowsBox(u, v, frame - 1) == ShowsBox(x, y, frame);
}

}  // namespace stillray
