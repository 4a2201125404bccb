// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// One writer, one reader, three values: neither ever waits for the other, not even where the
/// system takes the processor away from one of them at the worst moment.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

namespace stillray::view {

template <typename T>
class TripleBuffer {
 public:
  /// The writer's value: what it holds is left over from an earlier one.
  T& back() { return values_[back_]; }
  /// Hands the writer's value over; one that was not read yet is dropped.
  void Publish() {
    const auto mine = static_cast<uint8_t>(back_ | kFresh);
    back_ = middle_.exchange(mine, std::memory_order_acq_rel) & kPlace;
  }
  /// The newest value, if there is one that the reader has not seen; valid until the next call.
  const T* Take() {
    if ((middle_.load(std::memory_order_relaxed) & kFresh) == 0) {
      return nullptr;
    }
    front_ = middle_.exchange(front_, std::memory_order_acq_rel) & kPlace;
    return &values_[front_];
  }

 private:
  static constexpr uint8_t kPlace = 3;
  static constexpr uint8_t kFresh = 4;  // what lies in the middle was not read yet

  std::array<T, 3> values_;
  uint8_t back_ = 0;                 // the writer's
  std::atomic<uint8_t> middle_ = 1;  // place, and whether it is fresh
  uint8_t front_ = 2;                // the reader's
};

}  // namespace stillray::view
