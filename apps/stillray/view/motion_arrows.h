// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Draws motion as arrows over a picture.
#pragma once

#include "stillray/image.h"
#include "stillray/io.h"

namespace stillray::view {

inline constexpr int kArrowSpacing = 16;  ///< pixels between arrows in both directions

/// Length of an arrow in pixels: 3 for a tenth of a pixel per frame, 13 for one, 20 for four.
float ArrowLength(float pixels_per_frame);

/// Darkens the picture and draws an arrow every kArrowSpacing pixels: from the current position of
/// a surface to its next one. Motion slower than a twentieth of a pixel per frame is a dot, motion
/// of NaN a magenta dot, and that of infinity a cyan one.
/// \param motion  of the picture's size, as Guides::motion: towards the previous frame
void DrawMotionArrows(const Image2& motion, Rgb8Image* picture);

}  // namespace stillray::view
