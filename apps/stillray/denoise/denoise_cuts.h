// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Shot cuts, seen in the guides of two frames.
#pragma once

#include "stillray/frame.h"

namespace stillray {

/// How much of a frame is found again in the one before.
struct Agreement {
  double of_surfaces = 1;  ///< of all pixels with a surface; 1 where there is none
  double of_inside = 1;  ///< of those whose motion leads into the picture; 1 where hardly any does
};

/// Follows the motion of every pixel with a surface and asks whether the frame before has the same
/// surface there: depth, normal, albedo and id.
Agreement FindAgain(const Frame& now, const Guides& before);

/// Whether so little is found again that the two frames belong to different shots. Renderers see
/// no cuts: the motion at a cut is that of the new camera, small and smooth.
bool IsCut(const Agreement& agreement);

}  // namespace stillray
