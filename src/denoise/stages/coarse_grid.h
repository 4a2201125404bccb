// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The coarse grid of limit_history and restore_energy, pixel by pixel: blocks of 2x2 pixels, each
/// represented by the surface of its pixel nearest to the camera. The vector version is
/// simd/coarse_grid-inl.h.
#pragma once

#include "denoise/planes.h"

namespace stillray::reference {

/// A block and its representative: the pixel nearest to the camera.
struct Block {
  int x, y;         ///< position of the representative
  float weight[4];  ///< of the four pixels, row by row; 0: another surface, or none
};

Block BlockAt(const GuidePlanes& guides, int bx, int by);

/// Stores the surface of a block at the block's centre. The slope is per block (two pixels).
void StoreCoarse(const GuidePlanes& guides, const Block& block, int bx, int by,
                 GuidePlanes* coarse);

/// The four blocks around a pixel, for bilinear interpolation: its own block and the three nearest
/// ones. They may lie in the border of the grid.
struct BlocksAround {
  int x[4], y[4];
  float weight[4];  ///< bilinear, times the similarity of the surfaces
};

BlocksAround FindBlocksAround(const GuidePlanes& coarse, const GuidePlanes& guides, int x, int y);

}  // namespace stillray::reference
