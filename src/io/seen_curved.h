// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// What curved mirrors and curved glass show.
#pragma once

#include <cstdint>
#include <vector>

#include "io/seen_surfaces.h"
#include "stillray/frame.h"
#include "stillray/vec.h"

namespace stillray::io {

/// Which surfaces are curved mirrors or glass. Neighbours in a clean image see different things at
/// different depths, but these change smoothly: a surface shows an image if in enough of its
/// pixels, and there in three of four directions, the third difference of the seen depth is small
/// relative to the depth or to the second difference. On rough metal, whose layers are those of
/// random directions, it is not, for any number of samples.
/// \param seen  clears what pixels of another lobe see (DropOtherLobes), if they may see either
std::vector<PatchKind> CurvedKinds(const Frame& frame, const Patches& patches, SeenLobes lobes,
                                   Seen* seen);

/// Index of the pixel whose guides a pixel takes, y * width + x; negative where it takes none.
/// Pixels of a mirror take their own unless no neighbour sees the same. Pixels of glass, whose
/// layers are those of either lobe, do so if their neighbours support them; the outline of glass,
/// where lobes and directions mix most, keeps the guides of the surface. Others take those of a
/// neighbour, up to three pixels away, that sees what most of the neighbours see.
Plane<int32_t> CurvedSources(const Seen& seen, const Guides& guides, const Patches& patches,
                             const std::vector<PatchKind>& kinds);

}  // namespace stillray::io
