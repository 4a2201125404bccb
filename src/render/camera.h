// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The camera at one moment.
#pragma once

#include "stillray/scene.h"

namespace stillray::render {

/// A camera in world space for one image resolution. Axes have unit length: the scale of its node
/// does not change the view.
struct CameraView {
  vec3 position;
  vec3 right;
  vec3 up;
  vec3 forward;
  float half_width = 0;   ///< tangent of half the horizontal angle of view
  float half_height = 0;  ///< tangent of half the vertical angle of view
  float width = 0;        ///< pixels
  float height = 0;
  /// Shift of the image plane against the axes, in tangents; 0 at the centre of the lens.
  vec2 shift = vec2(0.0f);
  float lens_radius = 0;    ///< 0: a pinhole
  float inverse_focus = 0;  ///< 1 / depth of the plane of focus

  /// The pinhole camera at a point of the lens; its image is shifted so that points in the plane of
  /// focus project to the same pixel.
  /// \param lens  point in the unit disk (LensPoint)
  CameraView Through(vec2 lens) const;
  /// Unit direction through `pixel` (centre of the top left pixel: 0.5, 0.5).
  vec3 Direction(vec2 pixel) const;
  /// Projects the point at `offset` from the camera's position to pixel coordinates; points behind
  /// the camera are mirrored. The result is always finite.
  vec2 Project(vec3 offset) const;
  /// Linear view-space z of a point.
  float Depth(vec3 point) const;
};

/// Focal length in pixels (Frame::focal_pixels).
inline float FocalPixels(const CameraView& camera) {
  return 0.5f * camera.width / camera.half_width;
}

/// \param world          world transform of the camera's node
/// \param width, height  image resolution in pixels; the vertical angle of view is kept
CameraView MakeCameraView(const Camera& camera, const mat4& world, int width, int height);

}  // namespace stillray::render
