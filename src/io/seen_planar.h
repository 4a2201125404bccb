// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// What planar mirrors and panes of glass show.
#pragma once

#include <cstdint>
#include <vector>

#include "io/seen_surfaces.h"
#include "stillray/frame.h"
#include "stillray/vec.h"

namespace stillray::io {

/// Which patches are planar and show an image: four fifths of their pixels lie on one plane, and
/// see what most of their neighbours see. Neighbours on a large ball are as good as on one plane;
/// its patch as a whole is not.
std::vector<PatchKind> PlanarKinds(const Seen& seen, const Patches& patches, const Guides& guides,
                                   SeenLobes lobes);

/// Which patches are planar, whatever they show: 1, else 0.
std::vector<uint8_t> ArePlanar(const Patches& patches, const Guides& guides);

/// The pixel whose guides a pixel takes: itself, a neighbour that sees what most see if the pixel
/// alone sees something else, or (-1, -1) where nothing is seen in common. Denoising Data are
/// random in some pixels of every mirror.
/// \param other_lobe  whether the pixel's own guides are those of the surface's other lobe
ivec2 PlanarSource(const Seen& seen, const Patches& patches, bool other_lobe, int x, int y);

}  // namespace stillray::io
