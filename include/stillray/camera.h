// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Cameras as matrices, and what follows from them: focal length, motion of what stands still.
#pragma once

#include <array>

#include "stillray/image.h"

namespace stillray {

/// The standard attributes worldToCamera and worldToNDC of an EXR file: rows of 4 x 4 matrices for
/// row vectors, as defined by OpenEXR.
struct CameraMatrices {
  std::array<double, 16> world_to_camera;
  std::array<double, 16> world_to_ndc;
  /// NDC are those of the standard, from 0 to 1 from the upper left corner. If not set, the
  /// convention follows from where the viewing axis projects to, which a strongly shifted lens
  /// makes ambiguous.
  bool is_standard = false;
};

/// From matrices for column vectors, row by row (docs/cameras.md).
/// \param world_to_camera  x to the right, y up; the camera looks along -z or z, and is not scaled
/// \param projection       from camera to clip space, where x and y of the picture run from -1 to 1
///     times w. Of any graphics interface: the direction of y is recognised, and the row of z is
///     not used
CameraMatrices MatricesOf(const std::array<double, 16>& world_to_camera,
                          const std::array<double, 16>& projection);

/// The focal length in pixels, vertically: the height of the picture over that in tangents of the
/// angle of view. 0 without perspective.
double FocalPixels(const CameraMatrices& camera, int width, int height);

/// Frame::focal_pixels: the same of a camera whose optical axis passes through the centre of the
/// picture, up to 2 % of its width, and whose pixels are square, up to 2 %; else 0.
double CentredFocalPixels(const CameraMatrices& camera, int width, int height);

/// Motion of a still scene from the cameras of two frames: the point seen at p is at p + result(p)
/// in the picture of the other camera, in pixels, right and down. Zero where depth is infinite;
/// points behind the other camera lead out of the picture. Device coordinates run from 0 to 1 from
/// the upper left corner (the standard) or from -1 to 1 with y up, and the camera looks along +z
/// (the standard) or -z; the projection of the viewing axis distinguishes them.
/// \param depth  linear; of the size of both pictures
Image2 MotionFromCameras(const Image1& depth, const CameraMatrices& now,
                         const CameraMatrices& other);

}  // namespace stillray
