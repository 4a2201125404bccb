// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Dense optical flow between two frames from their guides alone, which are almost noise-free.
/// Source: Kroeger et al. 2016, Fast Optical Flow using Dense Inverse Search: from coarse to fine,
/// patches are aligned by the inverse compositional method (Baker and Matthews 2004), and
/// overlapping patches give each pixel its motion. Departs from it: eight channels in place of
/// brightness; pixels of other surfaces have less weight in a patch; patches also try the motion of
/// their neighbours, and search if no motion fits; a pixel takes the motion of the patches that fit
/// it best, so that motion is not blurred across silhouettes; no variational refinement.
#pragma once

#include <cstddef>

#include "motion/guide_pyramid.h"
#include "stillray/image.h"
#include "stillray/vec.h"

namespace stillray::motion {

struct Matched {
  /// Pixels: the point visible at p is at p + motion(p) in `before`.
  Image2 motion;
  /// Structure: change of the guides per pixel, in the direction of the smallest change. 0 on plain
  /// surfaces and along straight edges.
  Image1 structure;
};

/// The motion of each pixel of `now`. Results do not depend on the number of threads.
/// \param start   initial motion of the size of the finest level, or empty: tried first on every
///     level, and kept where no other motion fits better
/// \param finest  index of the level at which to end
Matched MatchPyramids(const GuidePyramid& now, const GuidePyramid& before, const Image2& start,
                      size_t finest = 0);

/// The squared difference of a pixel's channels and those at the position given by a motion,
/// interpolated between pixels.
float PixelCost(const GuideLevel& now, const GuideLevel& before, int x, int y, vec2 motion);

/// Forward-backward consistency of the motion between two frames, 0 to 1. 0 where motion points
/// outside the image.
/// \param forth  of pixels of `now`; back: of pixels of `before`
Image1 AgreementOf(const Image2& forth, const Image2& back);

}  // namespace stillray::motion
