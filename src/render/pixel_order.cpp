// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "render/pixel_order.h"

#include <algorithm>
#include <utility>

#include "core/random.h"

namespace stillray::render {
namespace {

/// Pairs (a, b) as fractions of 2^32: the pair of the plastic number, and pairs found by random
/// search. The minimum of |p|^2 |a x + b y - z| over all p = (x, y) up to 40 pixels long and
/// integer z is between 0.211 and 0.245.
constexpr uint32_t kPairs[][2] = {
    {3242174888u, 2447445414u}, {2914603462u, 1979640621u}, {2600400834u, 1189413883u},
    {2007987405u, 1490448141u}, {2817468481u, 1009746811u}, {1670759458u, 3133651089u},
    {1549589841u, 2275782911u}, {1291101529u, 1898405610u}, {997196917u, 2744136210u},
    {1469106448u, 1004949333u}, {1053899075u, 1745517659u}, {3298934315u, 1550796726u},
    {2427459681u, 1035039874u},
};
constexpr uint32_t kPairCount = sizeof(kPairs) / sizeof(kPairs[0]);

/// Cycles from which cells of 2x2 and 4x4 pixels are used: cells cover at most a quarter of a
/// frame's mean area per traced pixel, so that the position within the cell does not degrade the
/// distribution of the cells.
constexpr uint32_t kCycleOfCells2 = 16;
constexpr uint32_t kCycleOfCells4 = 64;

int64_t FloorDivide(int64_t a, int64_t b) {
  return a / b - (a % b < 0 ? 1 : 0);
}

/// The smallest rank in frame f of the cycle: ceil(f 2^32 / cycle).
uint64_t WindowStart(uint64_t f, uint64_t cycle) {
  return ((f << 32) + cycle - 1) / cycle;
}

/// Slots of a cell in the order of Bayer's matrix: any four consecutive slots lie in its four
/// quarters, also if slots are XORed with a constant.
PixelPosition PlaceOfSlot(uint32_t slot, int cell_bits) {
  PixelPosition place;
  for (int bit = cell_bits - 1; bit >= 0; --bit, slot >>= 2) {
    const uint32_t quarter = slot & 3u;  // top left, bottom right, top right, bottom left
    place.x |= static_cast<int>((quarter ^ (quarter >> 1)) & 1u) << bit;
    place.y |= static_cast<int>(quarter & 1u) << bit;
  }
  return place;
}

uint32_t SlotOfPlace(PixelPosition place, int cell_bits) {
  uint32_t slot = 0;
  for (int bit = 0; bit < cell_bits; ++bit) {
    const auto x = static_cast<uint32_t>(place.x >> bit) & 1u;
    const auto y = static_cast<uint32_t>(place.y >> bit) & 1u;
    slot = (slot << 2) | ((x ^ y) << 1) | y;
  }
  return slot;
}

}  // namespace

PixelOrder::PixelOrder(int cycle, uint64_t seed, int64_t frame_index)
    : cycle_(static_cast<uint32_t>(cycle)), cycle_index_(FloorDivide(frame_index, cycle)) {
  cell_bits_ = cycle_ >= kCycleOfCells4 ? 2 : cycle_ >= kCycleOfCells2 ? 1 : 0;
  const auto f = static_cast<uint64_t>(frame_index - cycle_index_ * cycle);
  first_rank_ = static_cast<uint32_t>(WindowStart(f, cycle_));
  last_rank_ = static_cast<uint32_t>(WindowStart(f + 1, cycle_) - 1);
  const auto number = static_cast<uint64_t>(cycle_index_);
  uint32_t hash = HashCombine(static_cast<uint32_t>(seed), static_cast<uint32_t>(seed >> 32));
  hash = HashCombine(hash, static_cast<uint32_t>(number));
  hash = HashCombine(hash, static_cast<uint32_t>(number >> 32));
  const uint32_t* pair = kPairs[(hash >> 2) % kPairCount];
  step_x_ = pair[0];
  step_y_ = pair[1];
  if ((hash & 1u) != 0) {
    std::swap(step_x_, step_y_);
  }
  if ((hash & 2u) != 0) {
    step_x_ = 0u - step_x_;
  }
  offset_ = HashU32(hash);
  shuffle_seed_ = HashU32(offset_);
}

uint32_t PixelOrder::Shuffle(int cell_x, int cell_y) const {
  return HashCombine(HashCombine(shuffle_seed_, static_cast<uint32_t>(cell_x)),
                     static_cast<uint32_t>(cell_y));
}

int PixelOrder::FrameOf(int x, int y) const {
  const int cell_x = x >> cell_bits_;
  const int cell_y = y >> cell_bits_;
  PixelPosition place = {x - (cell_x << cell_bits_), y - (cell_y << cell_bits_)};
  const uint32_t shuffle = Shuffle(cell_x, cell_y);
  if ((shuffle & 16u) != 0) {
    std::swap(place.x, place.y);
  }
  const int slot_bits = 2 * cell_bits_;
  const uint32_t slot = SlotOfPlace(place, cell_bits_) ^ (shuffle & ((1u << slot_bits) - 1u));
  const uint64_t rank =
      FirstRank(cell_x, cell_y) + (static_cast<uint64_t>(slot) << (32 - slot_bits));
  return static_cast<int>((rank * cycle_) >> 32);
}

void PixelOrder::Collect(const Tile& region, std::vector<PixelPosition>* pixels) const {
  pixels->clear();
  const int slot_bits = 2 * cell_bits_;
  const uint32_t within_slot = 0xffffffffu >> slot_bits;
  const uint32_t window = last_rank_ - first_rank_;
  const int x_end = region.x0 + region.width;
  const int y_end = region.y0 + region.height;
  const int cells_end = (x_end - 1) >> cell_bits_;
  for (int cell_y = region.y0 >> cell_bits_; cell_y << cell_bits_ < y_end; ++cell_y) {
    for (int cell_x = region.x0 >> cell_bits_; cell_x <= cells_end; ++cell_x) {
      // Distance from the start of the window to the next slot of this cell. The window is no
      // longer than the distance between slots.
      const uint32_t into = (FirstRank(cell_x, cell_y) - first_rank_) & within_slot;
      if (into > window) {
        continue;
      }
      const uint32_t shuffle = Shuffle(cell_x, cell_y);
      const uint32_t slot = slot_bits == 0 ? 0u
                                           : ((first_rank_ + into) >> (32 - slot_bits)) ^
                                                 (shuffle & ((1u << slot_bits) - 1u));
      PixelPosition place = PlaceOfSlot(slot, cell_bits_);
      if ((shuffle & 16u) != 0) {
        std::swap(place.x, place.y);
      }
      place.x += cell_x << cell_bits_;
      place.y += cell_y << cell_bits_;
      if (place.x < x_end && place.y < y_end) {
        pixels->push_back(place);
      }
    }
  }
}

}  // namespace stillray::render
