// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The coarse grid of limit_history and restore_energy, pixel by pixel: blocks of 2x2 pixels, each
/// with the surface of its nearest pixel. The vector version is simd/coarse_grid-inl.h.
#pragma once

#include "denoise/planes.h"

namespace stillray::reference {

/// The pixels of a block, of which the nearest represents it.
struct Block {
  int x, y;         ///< of the nearest pixel
  float weight[4];  ///< of the pixels, by row; 0: another surface, or none
};

Block BlockAt(const GuidePlanes& guides, int bx, int by);

/// Stores the surface of a block at its centre; its slope is that over two pixels.
void StoreCoarse(const GuidePlanes& guides, const Block& block, int bx, int by,
                 GuidePlanes* coarse);

/// The four blocks around a pixel: its own, and those beside it on the pixel's side. They may lie
/// in the border of the grid.
struct BlocksAround {
  int x[4], y[4];
  float weight[4];  ///< bilinear, times the similarity of the surfaces
};

BlocksAround FindBlocksAround(const GuidePlanes& coarse, const GuidePlanes& guides, int x, int y);

}  // namespace stillray::reference
