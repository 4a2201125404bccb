// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Motion blur as a post-process of a sharp image.
#pragma once

#include "stillray/image.h"
#include "stillray/status.h"

namespace stillray::post {

struct Shutter {
  /// Fraction of the frame interval during which the shutter is open, 0..1, centred on the frame.
  float open = 0.5f;
  /// Half path lengths are clamped to this, in pixels; 0.5..256.
  float max_radius = 64;
};

/// Spreads the radiance of each pixel evenly over the path of its point while the shutter is open:
/// the motion towards the previous frame, times the open fraction, centred on the pixel. Moving
/// foreground is composited over the background by its coverage in time; moving background does not
/// spread over a static surface. If depths differ by less than 1/50, the faster surface is in
/// front.
///
/// Source: McGuire, Hennessy, Bukowski and Osman 2012, "A Reconstruction Filter for Plausible
/// Motion Blur": the largest motion of tiles, dilated over the tiles that it reaches, gives the
/// line of each pixel's taps. Departs from it: surfaces in front are gathered along that line, the
/// pixel's own surface and the background along the pixel's motion; weights are coverages of the
/// exact box blur, composited as in post/layers.h; no random offsets, a tap at each pixel of a
/// line.
/// \param motion  of the size of `colour`, in pixels, as Guides::motion. Where it is not finite, or
///     longer than the image's diagonal (unknown), the pixel counts as static
/// \param depth   of the size of `colour`; infinite, NaN, zero and negative depths count as
/// infinite \param colour  [in,out] scene-linear RGB; values that are not finite count as black
/// \return kInvalidArgument naming the setting or image; `colour` is then unchanged
Status MotionBlur(const Shutter& shutter, const Image2& motion, const Image1& depth,
                  Image3* colour);

}  // namespace stillray::post
