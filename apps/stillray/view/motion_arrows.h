// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Draws motion vectors as arrows over an image.
#pragma once

#include "stillray/image.h"
#include "stillray/io.h"

namespace stillray::view {

inline constexpr int kArrowSpacing = 16;  ///< pixels between arrows in both directions

/// Length of an arrow in pixels: 3 for a motion of 0.1 pixels per frame, 13 for 1, 20 for 4.
float ArrowLength(float pixels_per_frame);

/// Darkens the image and draws an arrow every kArrowSpacing pixels, from the current position of a
/// surface to its next position. Motion below 0.05 pixels per frame is drawn as a dot, NaN as a
/// magenta dot, infinity as a cyan dot.
/// \param motion  Guides::motion, towards the previous frame; of the image's size
void DrawMotionArrows(const Image2& motion, Rgb8Image* picture);

}  // namespace stillray::view
