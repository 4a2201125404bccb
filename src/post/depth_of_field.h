// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Depth of field as an effect on a finished picture that was taken through a pinhole.
#pragma once

#include "stillray/image.h"
#include "stillray/status.h"

namespace stillray::post {

/// A thin lens with a round aperture, in the terms of docs/lens.md.
struct ThinLens {
  float radius = 0;  ///< of the aperture, in the unit of depth; >= 0
  float focus = 1;   ///< depth of the plane of focus; > 0, may be +infinity
  /// Pixels of the picture per tangent of the angle of view: height / (2 tan(yfov / 2)).
  float pixels_per_tangent = 1;
  /// Larger circles of confusion are drawn with this radius, in pixels; 0.5..kLargestRadius. The
  /// time grows with its square.
  float max_radius = 32;
};
inline constexpr float kLargestRadius = 256;

/// The height of a picture in pixels, over that in tangents of the angle of view.
/// \param yfov  vertical angle of view in radians; above 0, below pi
float PixelsPerTangent(int height, double yfov);

/// The radius of the circle of confusion in pixels, negative for what lies before the plane of
/// focus: radius (1 / focus - 1 / depth) pixels_per_tangent. Depths that are not above 0, or NaN,
/// count as infinite.
/// Source: Potmesil and Chakravarty 1981, "A Lens and Aperture Camera Model for Synthetic Image
/// Generation".
float CircleOfConfusion(const ThinLens& lens, float depth);

/// Gathers over discs: each pixel spreads its light evenly over its circle of confusion. Blurred
/// surfaces in front let what is behind them shine through in proportion to their share; what is
/// behind a surface spreads over it no further than the surface itself is blurred, so not at all
/// over a sharp one. Every pixel of a disc is a tap: no noise, and the same bits whatever the
/// number of threads. The border of the picture is repeated beyond it. \param depth   linear
/// view-space z of the picture's size; see CircleOfConfusion for the sky \param colour  [in,out]
/// scene-linear; light that is not finite counts as black \return kInvalidArgument naming the
/// setting or image; the picture is unchanged then
Status DepthOfField(const ThinLens& lens, const Image1& depth, Image3* colour);

}  // namespace stillray::post
