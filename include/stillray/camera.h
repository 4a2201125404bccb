// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Cameras as matrices; their focal length, and the motion of static surfaces between two cameras.
#pragma once

#include <array>

#include "stillray/image.h"

namespace stillray {

/// The standard attributes worldToCamera and worldToNDC of an EXR file: rows of 4 x 4 matrices for
/// row vectors, as defined by OpenEXR.
struct CameraMatrices {
  std::array<double, 16> world_to_camera;
  std::array<double, 16> world_to_ndc;
  /// world_to_ndc follows OpenEXR: x and y from 0 to 1, origin at the upper left corner. If false,
  /// the convention is inferred from the projection of the viewing axis, which is ambiguous for
  /// strongly shifted lenses.
  bool is_standard = false;
};

/// Converts matrices for column vectors in row-major order (docs/cameras.md).
/// \param world_to_camera  camera space: x right, y up, viewing direction -z or z; without scale
/// \param projection       camera to clip space, where the image spans -w..w in x and y. Of any
///     graphics API: the direction of y is inferred, and the row of z is ignored
CameraMatrices MatricesOf(const std::array<double, 16>& world_to_camera,
                          const std::array<double, 16>& projection);

/// The vertical focal length in pixels: height / (2 tan(vertical angle of view / 2)). 0 if the
/// projection has no perspective.
double FocalPixels(const CameraMatrices& camera, int width, int height);

/// The value for Frame::focal_pixels: FocalPixels() if the optical axis passes through the image
/// centre within 2 % of the width, and pixels are square within 2 %; else 0.
double CentredFocalPixels(const CameraMatrices& camera, int width, int height);

/// Motion of static surfaces between the cameras of two frames: the point visible at p is at p +
/// result(p) in the image of the other camera; pixels, x right, y down. Zero where depth is
/// infinite; for points behind the other camera p + result(p) lies outside the image. Device
/// coordinates run from 0 to 1 from the upper left corner (OpenEXR) or from -1 to 1 with y up, and
/// the camera looks along +z (OpenEXR) or -z; the projection of the viewing axis distinguishes
/// these conventions.
/// \param depth  linear, in scene units; its size is that of both frames
Image2 MotionFromCameras(const Image1& depth, const CameraMatrices& now,
                         const CameraMatrices& other);

}  // namespace stillray
