// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Shot cuts, found by comparing the guides of two frames.
#pragma once

#include "stillray/frame.h"

namespace stillray {

/// Agreement of a frame with the previous one.
struct Agreement {
  double of_surfaces = 1;  ///< of all pixels with a surface; 1 where there is none
  double of_inside = 1;  ///< of those whose motion leads into the picture; 1 where hardly any does
};

/// Follows the motion of every pixel with a surface, and compares depth, normal, albedo and id with
/// the previous frame there.
/// \param now  with depth, normal and motion
/// \param before  guides of the same size, with depth and normal
Agreement FindAgain(const Frame& now, const Guides& before);

/// Whether the agreement is so small that the two frames belong to different shots. Motion is no
/// sign of a cut: after one it is that of the new camera, small and smooth.
bool IsCut(const Agreement& agreement);

}  // namespace stillray
