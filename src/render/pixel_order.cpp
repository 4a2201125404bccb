// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "render/pixel_order.h"

#include "core/random.h"

namespace stillray::render {
namespace {

// Pairs (a, b) as fractions of 2^32, found by random search: the least |p|^2 |a x + b y - z| over
// all p = (x, y) up to 40 pixels long is above 0.2.
constexpr uint32_t kPairs[][2] = {
    {3243115741u, 2444868988u},
};

int64_t FloorDivide(int64_t a, int64_t b) {
  return a / b - (a % b < 0 ? 1 : 0);
}

// The least rank that falls into frame f of the cycle: ceil(f 2^32 / cycle).
uint64_t WindowStart(uint64_t f, uint64_t cycle) {
  return ((f << 32) + cycle - 1) / cycle;
}

}  // namespace

PixelOrder::PixelOrder(int cycle, uint64_t seed, int64_t frame_index)
    : cycle_(static_cast<uint32_t>(cycle)), cycle_index_(FloorDivide(frame_index, cycle)) {
  const auto f = static_cast<uint64_t>(frame_index - cycle_index_ * cycle);
  first_rank_ = static_cast<uint32_t>(WindowStart(f, cycle_));
  last_rank_ = static_cast<uint32_t>(WindowStart(f + 1, cycle_) - 1);
  const auto number = static_cast<uint64_t>(cycle_index_);
  uint32_t hash = HashCombine(static_cast<uint32_t>(seed), static_cast<uint32_t>(seed >> 32));
  hash = HashCombine(hash, static_cast<uint32_t>(number));
  hash = HashCombine(hash, static_cast<uint32_t>(number >> 32));
  constexpr uint32_t kPairCount = sizeof(kPairs) / sizeof(kPairs[0]);
  const uint32_t* pair = kPairs[(hash >> 2) % kPairCount];
  const bool swap = (hash & 1) != 0;
  step_x_ = swap ? pair[1] : pair[0];
  step_y_ = swap ? pair[0] : pair[1];
  if ((hash & 2) != 0) {
    step_x_ = 0u - step_x_;
  }
  offset_ = HashU32(hash);
}

int PixelOrder::FrameOf(int x, int y) const {
  return static_cast<int>((static_cast<uint64_t>(Rank(x, y)) * cycle_) >> 32);
}

void PixelOrder::Collect(const Tile& region, std::vector<PixelPosition>* pixels) const {
  pixels->clear();
  const uint32_t width = last_rank_ - first_rank_;
  for (int y = region.y0; y < region.y0 + region.height; ++y) {
    uint32_t from_first = Rank(region.x0, y) - first_rank_;
    for (int x = region.x0; x < region.x0 + region.width; ++x) {
      if (from_first <= width) {
        pixels->push_back({x, y});
      }
      from_first += step_x_;
    }
  }
}

}  // namespace stillray::render
