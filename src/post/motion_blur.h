// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Motion blur as an effect on a finished, sharp picture.
#pragma once

#include "stillray/image.h"
#include "stillray/status.h"

namespace stillray::post {

struct Shutter {
  /// Part of the time between two frames during which the shutter is open, 0..1, with the frame in
  /// the middle.
  float open = 0.5f;
  /// Longer paths are drawn with this half length, in pixels; 0.5..256.
  float max_radius = 64;
};

/// Spreads the light of each pixel evenly over the path of its point while the shutter is open: the
/// motion towards the previous frame, times the time, in both directions. Moving surfaces in front
/// let what is behind them shine through in proportion to their time there; what moves behind a
/// still surface does not spread over it. Where depths differ by less than a fiftieth, what moves
/// faster is in front.
///
/// Source: McGuire, Hennessy, Bukowski and Osman 2012, "A Reconstruction Filter for Plausible
/// Motion Blur": the largest motion of tiles, dilated over the tiles that it reaches, gives the
/// line of each pixel's taps. Departs from it: surfaces in front are gathered along that line, the
/// pixel's own surface and what is behind along its own motion; weights are shares of the exact box
/// blur, put together as in post/layers.h; no random offsets, a tap at each pixel of a line. \param
/// motion  pixels of the picture's size, as Guides::motion. Where it is not finite, or longer
///     than the picture's diagonal (it leads nowhere), the pixel counts as still.
/// \param depth   of the same size; infinite, NaN, zero and negative depths are infinitely far
/// \param colour  [in,out] scene-linear; light that is not finite counts as black
/// \return kInvalidArgument naming the setting or image; the picture is unchanged then
Status MotionBlur(const Shutter& shutter, const Image2& motion, const Image1& depth,
                  Image3* colour);

}  // namespace stillray::post
