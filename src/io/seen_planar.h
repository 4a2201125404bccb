// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Virtual images in planar mirrors and panes of glass.
#pragma once

#include <cstdint>
#include <vector>

#include "io/seen_surfaces.h"
#include "stillray/frame.h"
#include "stillray/vec.h"

namespace stillray::io {

/// Which patches are planar and have a virtual image: four fifths of their pixels lie on one plane,
/// and agree with most of their neighbours on the seen surface. On a large ball neighbouring pixels
/// almost lie on one plane; the patch as a whole does not.
std::vector<PatchKind> PlanarKinds(const Seen& seen, const Patches& patches, const Guides& guides,
                                   SeenLobes lobes);

/// Which patches are planar, with or without a virtual image: 1, else 0.
std::vector<uint8_t> ArePlanar(const Patches& patches, const Guides& guides);

/// The pixel whose virtual guides a pixel takes: itself, or a neighbour that agrees with the
/// majority if the pixel is an outlier, or (-1, -1) without a majority. Denoising Data are random
/// at some pixels of every mirror.
/// \param other_lobe  whether the pixel's own virtual guides belong to the surface's other lobe
ivec2 PlanarSource(const Seen& seen, const Patches& patches, bool other_lobe, int x, int y);

}  // namespace stillray::io
