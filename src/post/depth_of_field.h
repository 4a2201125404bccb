// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Depth of field as a post-process of an image of a pinhole camera.
#pragma once

#include "stillray/image.h"
#include "stillray/status.h"

namespace stillray::post {

/// A thin lens with a round aperture, in the terms of docs/lens.md.
struct ThinLens {
  float radius = 0;  ///< of the aperture, in the unit of depth; >= 0
  float focus = 1;   ///< depth of the plane of focus; > 0, may be +infinity
  /// Focal length in pixels: height / (2 tan(yfov / 2)).
  float pixels_per_tangent = 1;
  /// Circles of confusion are clamped to this radius, in pixels; 0.5..kLargestRadius. The time
  /// grows with its square.
  float max_radius = 32;
};
inline constexpr float kLargestRadius = 256;

/// Focal length in pixels: height / (2 tan(yfov / 2)).
/// \param yfov  vertical angle of view in radians; above 0, below pi
float PixelsPerTangent(int height, double yfov);

/// The radius of the circle of confusion in pixels, negative for points before the plane of focus:
/// radius (1 / focus - 1 / depth) pixels_per_tangent. Depths that are not above 0, or NaN, count as
/// infinite. Source: Potmesil and Chakravarty 1981, "A Lens and Aperture Camera Model for Synthetic
/// Image Generation".
float CircleOfConfusion(const ThinLens& lens, float depth);

/// Gathers over discs: each pixel spreads its radiance evenly over its circle of confusion. Blurred
/// foreground is composited over the background by its coverage; background spreads over a surface
/// only as far as that surface is blurred, so not over a sharp one. Every pixel of a disc is a tap:
/// no noise, and results do not depend on the number of threads. Border pixels are repeated outside
/// the image.
/// \param depth   linear view-space z, of the size of `colour`; see CircleOfConfusion for the sky
/// \param colour  [in,out] scene-linear RGB; values that are not finite count as black
/// \return kInvalidArgument naming the setting or image; `colour` is then unchanged
Status DepthOfField(const ThinLens& lens, const Image1& depth, Image3* colour);

}  // namespace stillray::post
