// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Where everything moves, as arrows over a picture.
#pragma once

#include "stillray/image.h"
#include "stillray/io.h"

namespace stillray::view {

inline constexpr int kArrowSpacing = 16;  ///< pixels between arrows, both ways

/// Length of an arrow in pixels: 3 for a tenth of a pixel per frame, 13 for one, 20 for four.
float ArrowLength(float pixels_per_frame);

/// Darkens the picture and draws an arrow every kArrowSpacing pixels: it begins where a surface is,
/// and points to where it goes. Slower than a twentieth of a pixel per frame: a dot. Motion that is
/// not finite: a magenta dot.
/// \param motion  of the picture's size, as Guides::motion: back to the frame before
void DrawMotionArrows(const Image2& motion, Rgb8Image* picture);

}  // namespace stillray::view
