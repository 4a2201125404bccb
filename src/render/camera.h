// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The camera at one moment.
#pragma once

#include "stillray/scene.h"

namespace stillray::render {

/// A camera placed in the world, for one picture size. Axes have unit length: scaling the node does
/// not change the view.
struct CameraView {
  vec3 position;
  vec3 right;
  vec3 up;
  vec3 forward;
  float half_width = 0;   ///< tangent of half the angle of view
  float half_height = 0;  ///< likewise, vertically
  float width = 0;        ///< pixels
  float height = 0;
  /// Of the picture against the axes, in tangents: 0 for the lens's centre.
  vec2 shift = vec2(0.0f);
  float lens_radius = 0;    ///< 0: a pinhole
  float inverse_focus = 0;  ///< 1 / depth of the plane of focus

  /// The pinhole camera at a point of the lens, whose picture has the plane of focus at the same
  /// place.
  /// \param lens  in the unit circle (LensPoint)
  CameraView Through(vec2 lens) const;
  /// Unit direction through `pixel` (centre of the top left pixel: 0.5, 0.5).
  vec3 Direction(vec2 pixel) const;
  /// Projects the point at `offset` from the camera's position to the picture; points behind the
  /// camera are mirrored. The result is always finite.
  vec2 Project(vec3 offset) const;
  /// Linear view-space z of a point.
  float Depth(vec3 point) const;
};

/// Frame::focal_pixels of its frames.
inline float FocalPixels(const CameraView& camera) {
  return 0.5f * camera.width / camera.half_width;
}

/// \param world          of the camera's node
/// \param width, height  of the picture in pixels; the vertical angle of view is kept
CameraView MakeCameraView(const Camera& camera, const mat4& world, int width, int height);

}  // namespace stillray::render
