// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The pinhole camera of one moment.
#pragma once

#include "stillray/scene.h"

namespace stillray::render {

/// A camera placed in the world, for pictures of one size. Axes have unit length: a scaled node
/// does not change what its camera sees.
struct CameraView {
  vec3 position;
  vec3 right;
  vec3 up;
  vec3 forward;
  float half_width = 0;   ///< tangent of half the angle of view
  float half_height = 0;  ///< likewise, vertically
  float width = 0;        ///< pixels
  float height = 0;

  /// Unit direction in which the camera sees `pixel` (centre of the top left pixel: 0.5, 0.5).
  vec3 Direction(vec2 pixel) const;
  /// Where the camera sees what lies at `offset` from its position; of things behind it, where
  /// their mirror image would be. Finite always.
  vec2 Project(vec3 offset) const;
  /// Linear view-space z of a point.
  float Depth(vec3 point) const;
};

/// \param world          of the camera's node
/// \param width, height  of the picture in pixels; the vertical angle of view is kept
CameraView MakeCameraView(const Camera& camera, const mat4& world, int width, int height);

}  // namespace stillray::render
