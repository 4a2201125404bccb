// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "io/reflected_motion.h"

#include <algorithm>
#include <cmath>

#include "core/pixels.h"
#include "io/seen_surfaces.h"

namespace stillray::io {
namespace {

/// The position of the previous camera: the point without a projection (null space of its matrix).
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

vec2 Between(const vec2 (&corner)[2][2], vec2 f) {
  return (1 - f.y) * ((1 - f.x) * corner[0][0] + f.x * corner[0][1]) +
         f.y * ((1 - f.x) * corner[1][0] + f.x * corner[1][1]);
}

/// The Newton step to the zero of a bilinear function, from its value and slopes at a position in
/// its cell.
vec2 StepToZero(const vec2 (&corner)[2][2], vec2 f) {
  const vec2 value = Between(corner, f);
  const vec2 a = (1 - f.y) * (corner[0][1] - corner[0][0]) + f.y * (corner[1][1] - corner[1][0]);
  const vec2 b = (1 - f.x) * (corner[1][0] - corner[0][0]) + f.x * (corner[1][1] - corner[0][1]);
  const float determinant = a.x * b.y - b.x * a.y;
  return vec2(b.x * value.y - b.y * value.x, a.y * value.x - a.x * value.y) / determinant;
}

}  // namespace

ReflectedMotion::ReflectedMotion(const Guides& guides, const Lens& lens, const CameraMotion& camera,
                                 const mat3& to_camera)
    : guides_(guides),
      lens_(lens),
      tangent_(static_cast<float>(std::sqrt(lens.k))),
      to_camera_(to_camera),
      last_eye_(LastEye(camera, lens)) {}

vec3 ReflectedMotion::PointAt(int x, int y) const {
  const vec2 p = PixelPoint(guides_.depth, x, y) - vec2(lens_.centre);
  return guides_.depth(x, y) * vec3(tangent_ * p.x, tangent_ * p.y, 1.0f);
}

vec3 ReflectedMotion::NormalAt(int x, int y) const {
  return glm::normalize(to_camera_ * VectorAt(guides_.normal, x, y));
}

ReflectedMotion::Target ReflectedMotion::TargetOf(int x, int y, float seen) const {
  constexpr float kFarAway = 1e5f;  // of the surface's distance
  const vec3 point = PointAt(x, y);
  const vec3 normal = NormalAt(x, y);
  const float distance = glm::length(point);
  const float way = (seen - guides_.depth(x, y)) * distance / point.z;
  const vec3 direction = glm::reflect(point / distance, normal);
  const vec3 axis_x = Perpendicular(normal);
  return {point + std::min(way, kFarAway * distance) * direction, axis_x,
          glm::cross(normal, axis_x)};
}

vec2 ReflectedMotion::DeviationAt(int x, int y, const Target& target) const {
  const vec3 point = PointAt(x, y);
  const vec3 normal = NormalAt(x, y);
  const vec3 half = glm::normalize(last_eye_ - point) + glm::normalize(target.point - point);
  const vec3 deviation = half - dot(half, normal) * normal;
  return {dot(deviation, target.axis_x), dot(deviation, target.axis_y)};
}

std::optional<ReflectedMotion::Cell> ReflectedMotion::CellAt(int x, int y, int u, int v,
                                                             const Target& target) const {
  Cell cell;
  for (int j = 0; j < 2; ++j) {
    for (int i = 0; i < 2; ++i) {
      if (!IsInside(guides_.depth, u + i, v + j) || !OnSameCurve(guides_, x, y, u + i, v + j)) {
        return std::nullopt;
      }
      cell.deviation[j][i] = DeviationAt(u + i, v + j, target);
      cell.motion[j][i] = {guides_.motion[0](u + i, v + j), guides_.motion[1](u + i, v + j)};
      if (!(std::abs(cell.motion[j][i].x) < static_cast<float>(guides_.depth.width()))) {
        return std::nullopt;  // unknown
      }
    }
  }
  return cell;
}

std::optional<vec2> ReflectedMotion::At(int x, int y, float seen) const {
  constexpr int kSteps = 5;
  constexpr float kPrecision = 0.02f;   // pixels
  constexpr float kLongestStep = 0.1f;  // fraction of the image width
  const float longest = kLongestStep * static_cast<float>(guides_.depth.width());
  const Target target = TargetOf(x, y, seen);
  vec2 at(x, y);
  for (int i = 0; i < kSteps; ++i) {
    const vec2 corner = glm::floor(at);
    const std::optional<Cell> cell =
        CellAt(x, y, static_cast<int>(corner.x), static_cast<int>(corner.y), target);
    const vec2 step = cell ? StepToZero(cell->deviation, at - corner) : vec2(2 * longest);
    if (!(glm::length(step) < longest)) {
      return std::nullopt;
    }
    if (glm::length(step) < kPrecision) {
      return at + step + Between(cell->motion, at - corner) - vec2(x, y);
    }
    at += step;
  }
  return std::nullopt;
}

}  // namespace stillray::io
