// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The motion of a camera, and of what it sees.
#pragma once

#include <optional>

#include <glm/mat4x3.hpp>
#include <glm/mat4x4.hpp>

#include "stillray/camera.h"
#include "stillray/vec.h"

namespace stillray {

/// Positions in the picture relative to its centre, 1 at its left and right side.
vec2 PicturePoint(int width, int height, float x, float y);
/// That of the centre of a pixel.
vec2 PixelPoint(const Image1& plane, int x, int y);

/// Where static points were in the previous picture, as a function of their place and depth:
/// (x, y, w) = map (p, 1, depth_unit / z), place (x, y) / w. This holds for all perspective cameras
/// that move, turn and zoom, and for parallel ones that do not turn (homography of the plane at
/// infinity, and epipole; Hartley and Zisserman, Multiple View Geometry, section 13).
struct CameraMotion {
  glm::dmat4x3 map;  ///< columns belong to x, y, 1 and depth_unit / z
  double depth_unit = 1;
  /// The points that were fitted move and lie in one plane: motion at other depths is arbitrary.
  bool of_one_plane = false;

  /// \param p  see PicturePoint
  /// \param z  > 0, may be infinite
  /// \return pixels from the point's place now to its place in the previous frame
  vec2 MotionOf(vec2 p, double z, int width) const;
};

bool HasInverse(const CameraMatrices& camera);

/// Whether the camera is a perspective one: the distance along its viewing axis alone divides.
bool HasPerspective(const CameraMatrices& camera, int width, int height);

/// The exact CameraMotion of perspective cameras.
/// \param width, height  of both pictures
/// \return nothing for other cameras, whose motion is not of this form, and for matrices without an
///     inverse
std::optional<CameraMotion> MotionOfCamera(const CameraMatrices& now, const CameraMatrices& before,
                                           int width, int height);

/// From places in the picture to the camera's space: map (p, 1, 1 / z) is (P / z, 1 / z), for the
/// point P at depth z that is seen at p (PicturePoint).
/// \return nothing without perspective or an inverse
std::optional<glm::dmat4> FromPicture(const CameraMatrices& camera, int width, int height);

}  // namespace stillray
