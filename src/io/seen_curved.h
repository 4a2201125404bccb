// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Virtual images in curved mirrors and curved glass.
#pragma once

#include <cstdint>
#include <vector>

#include "io/seen_surfaces.h"
#include "stillray/frame.h"
#include "stillray/vec.h"

namespace stillray::io {

/// Which patches are curved mirrors or glass. Neighbouring pixels of a clean virtual image have
/// different seen depths, which vary smoothly: a patch has a virtual image if at enough of its
/// pixels, in three of four directions, the third difference of the seen depth is small relative to
/// the depth or to the second difference. It is large on rough metal, whose layers belong to random
/// directions, for any number of samples.
/// \param seen  pixels of another lobe are cleared (DropOtherLobes), if both lobes may occur
std::vector<PatchKind> CurvedKinds(const Frame& frame, const Patches& patches, SeenLobes lobes,
                                   Seen* seen);

/// Index of the pixel whose virtual guides a pixel takes, y * width + x; negative: none. Pixels of
/// a mirror take their own guides unless no neighbour agrees with them. Pixels of glass, whose
/// layers may belong to either lobe, take their own if their neighbours agree; at silhouettes of
/// glass, where lobes and directions mix most, the guides of the surface are kept. Other pixels
/// take the guides of a neighbour, up to three pixels away, that agrees with most of the
/// neighbours.
Plane<int32_t> CurvedSources(const Seen& seen, const Guides& guides, const Patches& patches,
                             const std::vector<PatchKind>& kinds);

}  // namespace stillray::io
