// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Dense motion between two frames from their guides alone, which have hardly any noise. Source:
/// Kroeger et al. 2016, Fast Optical Flow using Dense Inverse Search: from coarse to fine, patches
/// are aligned by the inverse compositional method (Baker and Matthews 2004), and overlapping
/// patches give each pixel its motion. Departs from it: eight channels in place of brightness;
/// patches count pixels of other surfaces less; patches also try the motion of their neighbours,
/// and search where nothing fits; a pixel follows the patches that fit it best, so that motion is
/// not blurred across outlines; no variational refinement.
#pragma once

#include <cstddef>

#include "motion/guide_pyramid.h"
#include "stillray/image.h"
#include "stillray/vec.h"

namespace stillray::motion {

struct Matched {
  /// Pixels: what is seen at p is at p + motion(p) in `before`.
  Image2 motion;
  /// How clearly guides tell where a pixel is: their change per pixel in the direction in which
  /// they change least. 0 on plain surfaces and along straight edges.
  Image1 structure;
};

/// The motion of each pixel of `now`. The same bits for any number of threads.
/// \param start   of the size of the finest level, or empty: tried first on every level, and kept
///     where it fits as well as anything else
/// \param finest  index of the level at which to end
Matched MatchPyramids(const GuidePyramid& now, const GuidePyramid& before, const Image2& start,
                      size_t finest = 0);

/// The squared difference of a pixel from the place to which a motion leads, between pixels.
float PixelCost(const GuideLevel& now, const GuideLevel& before, int x, int y, vec2 motion);

/// How much the motion of two frames to each other agrees, 0 to 1: going there and back must lead
/// to the pixel again. 0 where motion leads out of the picture.
/// \param forth  of pixels of `now`; back: of pixels of `before`
Image1 AgreementOf(const Image2& forth, const Image2& back);

}  // namespace stillray::motion
