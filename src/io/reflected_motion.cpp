// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "io/reflected_motion.h"

#include <cmath>

#include "core/pixels.h"
#include "io/seen_surfaces.h"

namespace stillray::io {
namespace {

/// The camera of the previous frame: the point that its projection maps to no place.
glm::dvec3 LastEye(const CameraMotion& camera, const Lens& lens) {
  const glm::dmat4x3& map = camera.map;
  const glm::dvec3 v = -glm::inverse(glm::dmat3(map[0], map[1], map[2])) * map[3];
  const double tangent = std::sqrt(lens.k);
  return camera.depth_unit * glm::dvec3(tangent * (v.x - lens.centre.x * v.z),
                                        tangent * (v.y - lens.centre.y * v.z), v.z);
}

/// A unit vector that is perpendicular to another one.
vec3 Perpendicular(vec3 n) {
  const vec3 other = std::abs(n.x) < 0.6f ? vec3(1, 0, 0) : vec3(0, 1, 0);
  return glm::normalize(glm::cross(n, other));
}

/// Values at the corners of a cell of 2x2 pixels, and between them.
struct Cell {
  vec2 value[2][2];  ///< [y][x]

  vec2 At(vec2 f) const {
    return (1 - f.y) * ((1 - f.x) * value[0][0] + f.x * value[0][1]) +
           f.y * ((1 - f.x) * value[1][0] + f.x * value[1][1]);
  }
  vec2 SlopeX(vec2 f) const {
    return (1 - f.y) * (value[0][1] - value[0][0]) + f.y * (value[1][1] - value[1][0]);
  }
  vec2 SlopeY(vec2 f) const {
    return (1 - f.x) * (value[1][0] - value[0][0]) + f.x * (value[1][1] - value[0][1]);
  }
};

}  // namespace

ReflectedMotion::ReflectedMotion(const Guides& guides, const Lens& lens, const CameraMotion& camera,
                                 const mat3& to_camera)
    : guides_(guides),
      lens_(lens),
      tangent_(static_cast<float>(std::sqrt(lens.k))),
      to_camera_(to_camera),
      last_eye_(LastEye(camera, lens)) {}

vec3 ReflectedMotion::PointAt(int x, int y) const {
  const vec2 p = PicturePoint(guides_.depth.width(), guides_.depth.height(),
                              static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f) -
                 vec2(lens_.centre);
  return guides_.depth(x, y) * vec3(tangent_ * p.x, tangent_ * p.y, 1.0f);
}

vec3 ReflectedMotion::NormalAt(int x, int y) const {
  return glm::normalize(to_camera_ * VectorAt(guides_.normal, x, y));
}

vec2 ReflectedMotion::DeviationAt(int x, int y, vec3 seen, vec3 axis_x, vec3 axis_y) const {
  const vec3 point = PointAt(x, y);
  const vec3 normal = NormalAt(x, y);
  const vec3 half = glm::normalize(last_eye_ - point) + glm::normalize(seen - point);
  const vec3 deviation = half - dot(half, normal) * normal;
  return {dot(deviation, axis_x), dot(deviation, axis_y)};
}

std::optional<vec2> ReflectedMotion::At(int x, int y, float seen) const {
  constexpr int kSteps = 5;
  constexpr float kPrecision = 0.02f;  // pixels
  constexpr float kFarAway = 1e5f;     // of the surface's distance
  const vec3 point = PointAt(x, y);
  const vec3 normal = NormalAt(x, y);
  const float distance = glm::length(point);
  const vec3 direction = glm::reflect(point / distance, normal);
  const float length = (seen - guides_.depth(x, y)) * distance / point.z;
  const vec3 target = point + std::min(length, kFarAway * distance) * direction;
  const vec3 axis_x = Perpendicular(normal);
  const vec3 axis_y = glm::cross(normal, axis_x);
  vec2 at(x, y);
  for (int step = 0; step < kSteps; ++step) {
    const int u = static_cast<int>(std::floor(at.x));
    const int v = static_cast<int>(std::floor(at.y));
    Cell deviation;
    Cell motion;
    for (int j = 0; j < 2; ++j) {
      for (int i = 0; i < 2; ++i) {
        if (!IsInside(guides_.depth, u + i, v + j) || !OnSameCurve(guides_, x, y, u + i, v + j)) {
          return std::nullopt;
        }
        deviation.value[j][i] = DeviationAt(u + i, v + j, target, axis_x, axis_y);
        motion.value[j][i] = {guides_.motion[0](u + i, v + j), guides_.motion[1](u + i, v + j)};
      }
    }
    const vec2 in_cell = at - vec2(u, v);
    const vec2 value = deviation.At(in_cell);
    const vec2 a = deviation.SlopeX(in_cell);
    const vec2 b = deviation.SlopeY(in_cell);
    const float determinant = a.x * b.y - b.x * a.y;
    const vec2 move =
        vec2(b.x * value.y - b.y * value.x, a.y * value.x - a.x * value.y) / determinant;
    const float longest = 0.1f * static_cast<float>(guides_.depth.width());
    if (!(glm::length(move) < longest)) {
      return std::nullopt;
    }
    if (glm::length(move) < kPrecision) {
      return at + move + motion.At(in_cell) - vec2(x, y);
    }
    at += move;
  }
  return std::nullopt;
}

}  // namespace stillray::io
