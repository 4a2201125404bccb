// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The motion of a camera, and of static points in its image.
#pragma once

#include <optional>

#include <glm/mat4x3.hpp>
#include <glm/mat4x4.hpp>

#include "stillray/camera.h"
#include "stillray/vec.h"

namespace stillray {

/// Converts a pixel position to a position relative to the image centre, in units of half the
/// width.
vec2 PicturePoint(int width, int height, float x, float y);
/// PicturePoint of the centre of a pixel.
vec2 PixelPoint(const Image1& plane, int x, int y);

/// Previous image positions of static points, as a function of position and depth: (x, y, w) = map
/// (p, 1, depth_unit / z), position (x, y) / w. Valid for perspective cameras that translate,
/// rotate and zoom, and for orthographic cameras without rotation (homography of the plane at
/// infinity, and epipole; Hartley and Zisserman, Multiple View Geometry, section 13).
struct CameraMotion {
  glm::dmat4x3 map;  ///< columns belong to x, y, 1 and depth_unit / z
  double depth_unit = 1;
  /// The fitted points move and lie in one plane: motion at other depths is arbitrary.
  bool of_one_plane = false;

  /// \param p  see PicturePoint
  /// \param z  > 0, may be infinite
  /// \return pixels from the point's position now to its position in the previous frame
  vec2 MotionOf(vec2 p, double z, int width) const;
};

bool HasInverse(const CameraMatrices& camera);

/// Whether the camera is perspective: w depends only on the distance along the viewing axis.
bool HasPerspective(const CameraMatrices& camera, int width, int height);

/// The exact CameraMotion of perspective cameras.
/// \param width, height  of both images, pixels
/// \return nothing for other cameras and for matrices without an inverse
std::optional<CameraMotion> MotionOfCamera(const CameraMatrices& now, const CameraMatrices& before,
                                           int width, int height);

/// From image positions to camera space: map (p, 1, 1 / z) is (P / z, 1 / z), for the point P at
/// depth z that is visible at p (PicturePoint).
/// \return nothing without perspective or an inverse
std::optional<glm::dmat4> FromPicture(const CameraMatrices& camera, int width, int height);

}  // namespace stillray
