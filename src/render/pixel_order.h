// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Which pixels get their path in which frame, where a path per pixel takes several frames.
#pragma once

#include <cstdint>
#include <vector>

#include "render/tiles.h"

namespace stillray::render {

struct PixelPosition {
  int x = 0;
  int y = 0;
};

/// The order in which one cycle of frames goes through the pixels, and the place of a frame in it.
///
/// A pixel's rank is frac(a x + b y + offset) with a and b badly approximable: pixels whose ranks
/// differ by less than w are then at least sqrt(c / w) apart, with c near that of the plastic
/// number (0.245; M. Roberts 2018, "The Unreasonable Effectiveness of Quasirandom Sequences").
/// Hence the pixels of one frame, whose ranks lie in a window of 1 / cycle, are well spread, those
/// of any consecutive frames together too, and this for any length of the cycle. Every cycle takes
/// another pair (a, b) and offset.
class PixelOrder {
 public:
  /// \param cycle  frames, >= 1
  PixelOrder(int cycle, uint64_t seed, int64_t frame_index);

  /// How many cycles were completed before this frame: the number of the pixels' sample.
  int64_t cycle_index() const { return cycle_index_; }
  /// Frame of the cycle in which the pixel gets its path: 0 to cycle - 1.
  int FrameOf(int x, int y) const;
  /// The pixels of the region whose turn it is, by rows.
  void Collect(const Tile& region, std::vector<PixelPosition>* pixels) const;

 private:
  uint32_t Rank(int x, int y) const {
    return offset_ + step_x_ * static_cast<uint32_t>(x) + step_y_ * static_cast<uint32_t>(y);
  }

  uint32_t cycle_;
  int64_t cycle_index_;
  uint32_t first_rank_;  // of this frame's window
  uint32_t last_rank_;   // inclusive
  uint32_t step_x_;
  uint32_t step_y_;
  uint32_t offset_;
};

}  // namespace stillray::render
