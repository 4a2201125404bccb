// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Code common to the effects: checks of the images, and removal of non-finite values that would
/// spread.
#pragma once

#include "stillray/image.h"
#include "stillray/status.h"

namespace stillray::post {

/// \return kInvalidArgument naming the image and both sizes
Status CheckSize(const char* name, int width, int height, const Image3& colour);

/// 1 / depth; 0, infinitely far, where depth is infinite, NaN, zero or negative.
float InverseDepth(float depth);

/// The colour with black in place of NaN and infinity.
Image3 FiniteLight(const Image3& colour, int border);

/// Repeats the outermost pixels in the border.
void FillBorder(Image1* plane);

}  // namespace stillray::post
