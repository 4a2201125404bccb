// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The viewer's free camera: its pose, and its movements by mouse and keys. Pure functions; angles
/// in radians, distances in scene units.
#pragma once

#include "stillray/scene.h"
#include "stillray/vec.h"

namespace stillray::view {

/// A camera rotated by `yaw` about the world's y, then by `pitch` about its own x, then by `roll`
/// about its own z. With all angles 0 it looks along -z, as in glTF. Movements are limited to
/// traceable positions (kMaxCoordinate).
struct ViewPose {
  vec3 position = vec3(0.0f);
  float yaw = 0;          ///< positive: to the left
  float pitch = 0;        ///< positive: up; -pi/2..pi/2
  float roll = 0;         ///< positive: counter-clockwise, seen from behind the camera
  float yfov = 0.8f;      ///< vertical angle of view
  float distance = 1.0f;  ///< distance to the orbit centre along the view axis; > 0
  /// Offset of the orbit centre from the view axis: to the right and up, scene units.
  vec2 aside = vec2(0.0f);

  vec3 Forward() const;
  vec3 Right() const;
  vec3 Up() const;
  vec3 Focus() const {
    return position + Forward() * distance + Right() * aside.x + Up() * aside.y;
  }
  bool operator==(const ViewPose&) const = default;
};

/// Camera-to-world transform of a node: columns right, up, backward, position.
mat4 ToMatrix(const ViewPose& pose);
/// The pose of a camera whose node has the transform `world`. Scaling is ignored.
ViewPose PoseFromMatrix(const mat4& world, float yfov, float distance);
/// The pose of one of the scene's cameras at `seconds`. The orbit centre is at the depth of the
/// centre of `bounds`.
ViewPose FilePose(const Scene& scene, const Aabb& bounds, int camera, double seconds);

/// Rotates around the orbit centre. Positive angles move the image right and down.
ViewPose Orbit(const ViewPose& pose, float right, float down);
/// Moves the pose along a horizontal circle around the orbit centre, which keeps its position in
/// the image.
/// \param angle   counter-clockwise, seen from above
/// \param radius  distance of the camera to the orbit centre, scene units; 0: unchanged
ViewPose OnOrbit(const ViewPose& pose, double angle, float radius);
/// Rotates without moving.
ViewPose Look(const ViewPose& pose, float right, float down);
/// Shifts the camera so that the point at the orbit centre follows the mouse.
/// \param dx, dy  pixels, y down
/// \param height  height of the image in pixels
ViewPose Pan(const ViewPose& pose, float dx, float dy, float height);
/// Moves towards the orbit centre by `steps` of a tenth (negative: away), never through it, and
/// never beyond kMaxCoordinate.
ViewPose Dolly(const ViewPose& pose, float steps);
/// Moves along the axes of the camera.
ViewPose Fly(const ViewPose& pose, float right, float up, float forward);
/// Narrows the field of view by `steps` of a tenth, within 1 to 160 degrees.
ViewPose Zoom(const ViewPose& pose, float steps);
/// Sets the orbit centre to the point seen at `depth` (along the viewing axis) at a position of the
/// image, without moving the camera. No effect if the depth is not finite and positive.
/// \param x, y    fractions of the image size, from the top left
/// \param aspect  width / height
ViewPose OrbitAround(const ViewPose& pose, float x, float y, float aspect, float depth);
/// OrbitAround, and rotates the camera to the point. No effect if the depth is not finite and
/// positive.
ViewPose FocusOn(const ViewPose& pose, float x, float y, float aspect, float depth);
/// Interpolates from a (t = 0) to b (t = 1), for smooth jumps to saved views.
ViewPose Between(const ViewPose& a, const ViewPose& b, float t);

}  // namespace stillray::view
