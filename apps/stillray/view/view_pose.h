// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The viewer's free camera: where it stands, and how it answers to mouse and keys. Pure functions;
/// angles in radians, distances in scene units.
#pragma once

#include "stillray/scene.h"
#include "stillray/vec.h"

namespace stillray::view {

/// A camera without tilt beyond `roll`: turned by `yaw` about the world's y, then by `pitch` about
/// its own x, then by `roll` about its own z. All 0 looks along -z, as glTF's cameras do. No
/// movement takes the camera farther out than rays can be traced from (kMaxCoordinate).
struct ViewPose {
  vec3 position = vec3(0.0f);
  float yaw = 0;          ///< positive: to the left
  float pitch = 0;        ///< positive: up; -pi/2..pi/2
  float roll = 0;         ///< positive: counter-clockwise, as the camera sees itself from behind
  float yfov = 0.8f;      ///< vertical angle of view
  float distance = 1.0f;  ///< to the point that orbiting turns around, along the view; > 0
  /// Where that point lies beside the middle of the view: to the right and up, scene units.
  vec2 aside = vec2(0.0f);

  vec3 Forward() const;
  vec3 Right() const;
  vec3 Up() const;
  vec3 Focus() const {
    return position + Forward() * distance + Right() * aside.x + Up() * aside.y;
  }
  bool operator==(const ViewPose&) const = default;
};

/// Camera to world, as a node's transform: columns right, up, backward, position.
mat4 ToMatrix(const ViewPose& pose);
/// The pose of a camera whose node stands at `world`. Scaling is left out.
ViewPose PoseFromMatrix(const mat4& world, float yfov, float distance);
/// The pose of one of the scene's cameras at `seconds`. Its distance reaches the middle of
/// `bounds`, seen along the view, so that orbiting turns around something sensible.
ViewPose FilePose(const Scene& scene, const Aabb& bounds, int camera, double seconds);

/// Turns around the focus. Positive angles move the picture right and down.
ViewPose Orbit(const ViewPose& pose, float right, float down);
/// Looks around without moving.
ViewPose Look(const ViewPose& pose, float right, float down);
/// Shifts camera and focus so that what lies at the focus follows the mouse.
/// \param dx, dy  pixels, y down
/// \param height  of the picture in pixels
ViewPose Pan(const ViewPose& pose, float dx, float dy, float height);
/// Nearer to the focus by `steps` of a tenth (negative: away), never through it, and never farther
/// away than kMaxCoordinate.
ViewPose Dolly(const ViewPose& pose, float steps);
/// Moves along the camera's own axes.
ViewPose Fly(const ViewPose& pose, float right, float up, float forward);
/// Narrower by `steps` of a tenth; the angle stays within 1 to 160 degrees.
ViewPose Zoom(const ViewPose& pose, float steps);
/// Makes the point seen at `depth` (along the viewing axis) at a place of the picture the one that
/// orbiting turns around; the camera stays as it is. Nothing changes for a depth that is not finite
/// and positive.
/// \param x, y    fractions of the picture, from the top left
/// \param aspect  width / height
ViewPose OrbitAround(const ViewPose& pose, float x, float y, float aspect, float depth);
/// The same, and the camera turns to the point. Nothing changes for a depth that is not finite
/// and positive.
ViewPose FocusOn(const ViewPose& pose, float x, float y, float aspect, float depth);
/// A pose on the way from a to b, for smooth jumps to saved views: t = 0 is a, 1 is b.
ViewPose Between(const ViewPose& a, const ViewPose& b, float t);

}  // namespace stillray::view
