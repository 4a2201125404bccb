// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Motion of the virtual images in curved mirrors.
#pragma once

#include <optional>

#include "io/camera_fit.h"
#include "stillray/frame.h"
#include "stillray/vec.h"

namespace stillray::io {

/// Finds the pixel at which a mirror reflected a point of the scene one frame ago. The point
/// follows from the surface and the path length; its reflection one frame ago was at the position
/// of the mirror where the normal bisects the directions to the point and to the previous camera
/// (law of reflection). Newton's method finds that position among the neighbouring pixels, whose
/// positions and normals are known. Mirror and point are assumed static, except for the image-space
/// motion of the mirror's surface.
class ReflectedMotion {
 public:
  /// \param guides     depth, normal, id and motion; must outlive this
  /// \param lens       of `guides.depth` and the lengths of paths
  /// \param to_camera  of normals, to right, down, forward (View)
  ReflectedMotion(const Guides& guides, const Lens& lens, const CameraMotion& camera,
                  const mat3& to_camera);

  /// \param seen  depth of the reflected point, as view-space z on the unfolded path; may be
  ///     infinite
  /// \return pixels from (x, y) to the reflection of the same point in the previous frame; nothing
  ///     if that is not on a pixel of the same surface
  std::optional<vec2> At(int x, int y, float seen) const;

 private:
  /// A point of the scene, and two axes of the surface that reflects it.
  struct Target {
    vec3 point;
    vec3 axis_x;
    vec3 axis_y;
  };
  /// Values at the corners of a cell of 2x2 pixels, [y][x].
  struct Cell {
    vec2 deviation[2][2];
    vec2 motion[2][2];
  };

  vec3 PointAt(int x, int y) const;
  vec3 NormalAt(int x, int y) const;
  Target TargetOf(int x, int y, float seen) const;
  /// Twice the deviation from the law of reflection along both axes.
  vec2 DeviationAt(int x, int y, const Target& target) const;
  /// The cell whose first pixel is (u, v); nothing if it leaves the surface at (x, y).
  std::optional<Cell> CellAt(int x, int y, int u, int v, const Target& target) const;

  const Guides& guides_;
  Lens lens_;
  float tangent_;
  mat3 to_camera_;
  vec3 last_eye_;  ///< camera of the previous frame, in camera space
};

}  // namespace stillray::io
