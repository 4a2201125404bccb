// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Detection of shot cuts by comparing the guides of two frames.
#pragma once

#include "stillray/frame.h"

namespace stillray {

/// Agreement of a frame with the previous one.
struct Agreement {
  double of_surfaces = 1;  ///< share among all pixels with a surface; 1 if there are none
  double of_inside = 1;    ///< share among those whose motion ends in the image; 1 if few do
};

/// Follows the motion of every pixel with a surface, and compares depth, normal, albedo and id with
/// the previous frame there.
/// \param now  with depth, normal and motion
/// \param before  guides of equal size, with depth and normal
Agreement FindAgain(const Frame& now, const Guides& before);

/// Whether the agreement is so small that the two frames belong to different shots. Motion does not
/// indicate a cut: after a cut it is the motion of the new camera, small and smooth.
bool IsCut(const Agreement& agreement);

}  // namespace stillray
