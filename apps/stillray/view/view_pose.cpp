// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "view/view_pose.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "scene/mesh_tools.h"

namespace stillray::view {
namespace {

constexpr float kPi = std::numbers::pi_v<float>;
constexpr float kPole = kPi / 2;
constexpr float kSmallestDistance = 1e-4f;
/// Maximum coordinate: the renderer rejects rays from farther away.
constexpr float kFarthest = kMaxCoordinate;

float WrapAngle(float angle) {
  return std::remainder(angle, 2 * kPi);
}

vec3 Normalised(vec3 v, vec3 fallback) {
  const float length = glm::length(v);
  return length > 0 && std::isfinite(length) ? v / length : fallback;
}

/// The camera's axes without roll.
struct LevelAxes {
  vec3 right;
  vec3 up;
};

LevelAxes Level(const ViewPose& pose) {
  const float sy = std::sin(pose.yaw);
  const float cy = std::cos(pose.yaw);
  const float sp = std::sin(pose.pitch);
  const float cp = std::cos(pose.pitch);
  return {vec3(cy, 0, -sy), vec3(sy * sp, cp, cy * sp)};
}

/// Clamps the distance to the supported range.
float BoundDistance(float distance) {
  return std::clamp(distance, kSmallestDistance, kFarthest);
}

/// Clamps the camera to traceable positions. NaN becomes the origin.
ViewPose Bounded(ViewPose pose) {
  for (int c = 0; c < 3; ++c) {
    const float p = pose.position[c];
    pose.position[c] = std::isnan(p) ? 0.0f : std::clamp(p, -kFarthest, kFarthest);
  }
  return pose;
}

ViewPose Turned(const ViewPose& pose, float right, float down) {
  ViewPose turned = pose;
  turned.yaw = WrapAngle(pose.yaw - right);
  turned.pitch = std::clamp(pose.pitch - down, -kPole, kPole);
  return turned;
}

}  // namespace

vec3 ViewPose::Forward() const {
  const float cp = std::cos(pitch);
  return {-std::sin(yaw) * cp, std::sin(pitch), -std::cos(yaw) * cp};
}

vec3 ViewPose::Right() const {
  const LevelAxes axes = Level(*this);
  return axes.right * std::cos(roll) + axes.up * std::sin(roll);
}

vec3 ViewPose::Up() const {
  const LevelAxes axes = Level(*this);
  return axes.up * std::cos(roll) - axes.right * std::sin(roll);
}

mat4 ToMatrix(const ViewPose& pose) {
  return {vec4(pose.Right(), 0), vec4(pose.Up(), 0), vec4(-pose.Forward(), 0),
          vec4(pose.position, 1)};
}

ViewPose PoseFromMatrix(const mat4& world, float yfov, float distance) {
  const vec3 forward = Normalised(-vec3(world[2]), vec3(0, 0, -1));
  const vec3 up = Normalised(vec3(world[1]), vec3(0, 1, 0));
  ViewPose pose;
  pose.position = vec3(world[3]);
  pose.yfov = yfov;
  pose.distance = BoundDistance(distance);
  pose.pitch = std::asin(std::clamp(forward.y, -1.0f, 1.0f));
  // For vertical view directions the up vector determines the yaw.
  const bool vertical = std::abs(forward.y) > 0.99999f;
  const vec3 ahead = vertical ? (forward.y > 0 ? -up : up) : forward;
  pose.yaw = std::atan2(-ahead.x, -ahead.z);
  const LevelAxes axes = Level(pose);
  pose.roll = vertical ? 0 : std::atan2(-dot(up, axes.right), dot(up, axes.up));
  return pose;
}

ViewPose FilePose(const Scene& scene, const Aabb& bounds, int camera, double seconds) {
  const Camera& file = scene.cameras[static_cast<size_t>(camera)];
  const mat4 world = NodeTransforms(scene, seconds)[static_cast<size_t>(file.node)];
  ViewPose pose = PoseFromMatrix(world, file.yfov, 1.0f);
  if (!(bounds.min.x <= bounds.max.x)) {
    return pose;
  }
  const float size = glm::length(bounds.max - bounds.min);
  const float along = dot((bounds.min + bounds.max) * 0.5f - pose.position, pose.Forward());
  // Inside the scene the centre of its bounds may be behind the camera.
  pose.distance = BoundDistance(std::max(along, 0.1f * size));
  return pose;
}

ViewPose Orbit(const ViewPose& pose, float right, float down) {
  const vec3 focus = pose.Focus();
  ViewPose turned = Turned(pose, right, down);
  turned.position += focus - turned.Focus();
  return Bounded(turned);
}

ViewPose OnOrbit(const ViewPose& pose, double angle, float radius) {
  const vec3 focus = pose.Focus();
  ViewPose turned = pose;
  turned.yaw = WrapAngle(static_cast<float>(std::remainder(pose.yaw + angle, 2.0 * kPi)));
  const float distance = glm::length(focus - pose.position);
  if (radius > 0 && distance > 0) {
    turned.distance = BoundDistance(pose.distance * (radius / distance));
    turned.aside = pose.aside * (turned.distance / pose.distance);
  }
  turned.position += focus - turned.Focus();
  return Bounded(turned);
}

ViewPose Look(const ViewPose& pose, float right, float down) {
  return Turned(pose, right, down);
}

ViewPose Pan(const ViewPose& pose, float dx, float dy, float height) {
  const float per_pixel = 2 * pose.distance * std::tan(pose.yfov / 2) / std::max(height, 1.0f);
  return Fly(pose, -dx * per_pixel, dy * per_pixel, 0);
}

ViewPose Dolly(const ViewPose& pose, float steps) {
  ViewPose moved = pose;
  moved.distance = BoundDistance(pose.distance * std::pow(0.9f, steps));
  moved.aside = pose.aside * (moved.distance / pose.distance);
  moved.position += pose.Focus() - moved.Focus();
  return Bounded(moved);
}

ViewPose Fly(const ViewPose& pose, float right, float up, float forward) {
  ViewPose moved = pose;
  moved.position += pose.Right() * right + pose.Up() * up + pose.Forward() * forward;
  return Bounded(moved);
}

ViewPose Zoom(const ViewPose& pose, float steps) {
  constexpr float kDegree = kPi / 180;
  ViewPose zoomed = pose;
  zoomed.yfov = std::clamp(pose.yfov * std::pow(0.9f, steps), kDegree, 160 * kDegree);
  return zoomed;
}

ViewPose OrbitAround(const ViewPose& pose, float x, float y, float aspect, float depth) {
  if (!(depth > 0) || !std::isfinite(depth)) {
    return pose;
  }
  const float half_height = std::tan(pose.yfov / 2) * depth;
  ViewPose around = pose;
  around.distance = BoundDistance(depth);
  around.aside = vec2((2 * x - 1) * half_height * aspect, (1 - 2 * y) * half_height);
  return around;
}

ViewPose FocusOn(const ViewPose& pose, float x, float y, float aspect, float depth) {
  if (!(depth > 0) || !std::isfinite(depth)) {
    return pose;
  }
  const vec3 offset = OrbitAround(pose, x, y, aspect, depth).Focus() - pose.position;
  const float distance = BoundDistance(glm::length(offset));
  const vec3 forward = offset / distance;
  ViewPose focused = pose;
  focused.distance = distance;
  focused.aside = vec2(0.0f);
  focused.pitch = std::asin(std::clamp(forward.y, -1.0f, 1.0f));
  if (std::abs(forward.y) < 0.99999f) {
    focused.yaw = std::atan2(-forward.x, -forward.z);
  }
  return focused;
}

ViewPose Between(const ViewPose& a, const ViewPose& b, float t) {
  const auto mix = [t](float from, float to) { return from + (to - from) * t; };
  ViewPose pose;
  pose.position = a.position + (b.position - a.position) * t;
  pose.yaw = WrapAngle(a.yaw + WrapAngle(b.yaw - a.yaw) * t);
  pose.pitch = mix(a.pitch, b.pitch);
  pose.roll = WrapAngle(a.roll + WrapAngle(b.roll - a.roll) * t);
  pose.yfov = mix(a.yfov, b.yfov);
  pose.distance = mix(a.distance, b.distance);
  pose.aside = a.aside + (b.aside - a.aside) * t;
  return t >= 1 ? b : pose;
}

}  // namespace stillray::view
