// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Estimates a frame's camera from its layers. Every static pixel gives an equation; all fits are
/// robust (iteratively reweighted least squares): moving objects, mirrors and noise do not affect
/// them as long as most pixels are static surfaces.
#pragma once

#include <optional>

#include "core/cameras.h"
#include "stillray/frame.h"
#include "stillray/vec.h"

namespace stillray::io {

/// The linear map of most normals: mapped = map * normal. It is zero in directions that the normals
/// do not span.
/// \param normal  zero where there is no surface
mat3 FitNormalMap(const Image3& normal, const Image3& mapped);

/// Distances along rays as a function of view-space z: (z - start) / cosine, with the cosine of the
/// angle between ray and viewing axis, 1 / sqrt(1 + k |p - centre|^2).
struct Lens {
  double k = 0;      ///< squared tangent of half the horizontal field of view; 0: parallel rays
  double start = 0;  ///< z at which distances begin: the near clipping plane
  glm::dvec2 centre{0.0};  ///< of projection, see PicturePoint

  double Cosine(vec2 p) const;
  double DepthOf(double distance, vec2 p) const { return distance * Cosine(p) + start; }
};

/// \param depth     view-space z; > 0 and finite on surfaces
/// \param distance  along the pixel's ray from the camera; > 0 where it is the distance of the
///     surface, or of the surface reflected in it
/// \return nothing if fewer than a third of the surfaces have a distance that fits
std::optional<Lens> FitLens(const Image1& depth, const Image1& distance);

/// A camera with perspective.
struct View {
  double tangent = 1;    ///< of half the horizontal field of view
  mat3 to_camera{1.0f};  ///< of normals, to right, down, forward; see FitNormalMap
};

/// The field of view for which the angles between surfaces by depth gradients equal those by
/// normals: on a plane with the camera-space normal n, 1 / z is n . (t x, t y, 1) times a constant,
/// for the tangent t.
/// \param depth   view-space z; > 0 and finite on surfaces
/// \param normal  towards the camera, of unit length, in any axes
/// \return nothing if less than half of the angles agree, as with normals of other surfaces, or if
///     all surfaces are parallel
std::optional<View> FitView(const Image1& depth, const Image3& normal);

/// \param motion  pixels, as Guides::motion
/// \return nothing if fewer than a third of the surfaces follow the fitted motion within 0.1
///     pixels. If all surfaces lie in one plane, motion at other depths is finite but arbitrary,
///     unless nothing moves (of_one_plane)
std::optional<CameraMotion> FitCameraMotion(const Image1& depth, const Image2& motion);

/// Both fits to the guides of a frame, computed at their first use.
class CameraFits {
 public:
  /// \param guides  depth, normal and motion, which may be empty; must outlive this
  explicit CameraFits(const Guides& guides)
      : CameraFits(guides.depth, guides.normal, guides.motion) {}
  /// As above, with another motion in place of guides.motion.
  CameraFits(const Image1& depth, const Image3& normal, const Image2& motion)
      : depth_(depth), normal_(normal), motion_(motion) {}

  /// Nothing if the motion is unknown at any depth.
  const std::optional<CameraMotion>& Motion();
  /// Whether Motion() is unknown because all static surfaces lie in one plane.
  bool SeesOnePlane();
  const std::optional<View>& FieldOfView();

 private:
  const Image1& depth_;
  const Image3& normal_;
  const Image2& motion_;
  std::optional<std::optional<CameraMotion>> camera_;
  bool sees_one_plane_ = false;
  std::optional<std::optional<View>> view_;
};

/// The motion of a virtual image that moves along with its surface: the surface's motion, plus the
/// difference of the camera's motion at the depths of image and surface.
/// \param guides  depth and motion of the surface
/// \param image   > 0, depth of the image
vec2 ImageMotion(const CameraMotion& camera, const Guides& guides, int x, int y, float image);

}  // namespace stillray::io
