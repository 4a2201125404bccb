// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Selects the pixels to trace in each frame, for rendering at less than one sample per pixel.
#pragma once

#include <cstdint>
#include <vector>

#include "render/tiles.h"

namespace stillray::render {

struct PixelPosition {
  int x = 0;
  int y = 0;
};

/// The order in which one cycle of frames visits the pixels, and the position of a frame in it.
///
/// Each pixel has a rank in [0, 1); frame f of the cycle traces the pixels with ranks from f /
/// cycle to (f + 1) / cycle. In short cycles the rank is frac(a x + b y + offset) with a and b
/// badly approximable: pixels whose ranks differ by less than w are then at least sqrt(c / w)
/// apart, with c near that of the plastic number, 0.245 (M. Roberts 2018, "The Unreasonable
/// Effectiveness of Quasirandom Sequences"). Hence the pixels of any consecutive frames are evenly
/// distributed, for any length of the cycle. In long cycles this rule selects cells of 2x2 or 4x4
/// pixels, and each cell visits its pixels in a shuffled order, one per 1/4 or 1/16 of the cycle:
/// as even and as irregular as blue noise. Every cycle uses another pair (a, b), offset and
/// shuffle.
class PixelOrder {
 public:
  /// \param cycle  length of the cycle in frames, 1..2^16
  PixelOrder(int cycle, uint64_t seed, int64_t frame_index);

  /// Number of completed cycles before this frame, which is the sample index of its pixels.
  int64_t cycle_index() const { return cycle_index_; }
  /// Frame of the cycle in which the pixel is traced: 0 to cycle - 1.
  int FrameOf(int x, int y) const;
  /// The pixels of the region to trace, by rows of cells.
  /// \param region  top left corner at multiples of 4
  void Collect(const Tile& region, std::vector<PixelPosition>* pixels) const;

 private:
  // The rank of a cell's first slot: less than one slot, 1 / 4^cell_bits_ of all ranks.
  uint32_t FirstRank(int cell_x, int cell_y) const {
    return (offset_ + step_x_ * static_cast<uint32_t>(cell_x) +
            step_y_ * static_cast<uint32_t>(cell_y)) >>
           (2 * cell_bits_);
  }
  uint32_t Shuffle(int cell_x, int cell_y) const;

  uint32_t cycle_;
  int64_t cycle_index_;
  int cell_bits_ = 0;    // a cell has 2^cell_bits_ pixels a side
  uint32_t first_rank_;  // ranks of this frame, in units of 1 / 2^32
  uint32_t last_rank_;   // inclusive
  uint32_t step_x_;
  uint32_t step_y_;
  uint32_t offset_;
  uint32_t shuffle_seed_;
};

}  // namespace stillray::render
