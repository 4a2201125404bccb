// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Lock-free triple buffer for one writer and one reader: neither waits for the other, even if one
/// thread is suspended.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

namespace stillray::view {

template <typename T>
class TripleBuffer {
 public:
  /// The writer's value; its initial content is an earlier value.
  T& back() { return values_[back_]; }
  /// Passes the writer's value to the reader; an earlier unread value is dropped.
  void Publish() {
    const auto mine = static_cast<uint8_t>(back_ | kFresh);
    back_ = middle_.exchange(mine, std::memory_order_acq_rel) & kPlace;
  }
  /// The newest value if it has not been taken; valid until the next call.
  const T* Take() {
    if ((middle_.load(std::memory_order_relaxed) & kFresh) == 0) {
      return nullptr;
    }
    front_ = middle_.exchange(front_, std::memory_order_acq_rel) & kPlace;
    return &values_[front_];
  }

 private:
  static constexpr uint8_t kPlace = 3;
  static constexpr uint8_t kFresh = 4;  // the middle value has not been read yet

  std::array<T, 3> values_;
  uint8_t back_ = 0;                 // index of the writer's value
  std::atomic<uint8_t> middle_ = 1;  // index, and the fresh flag
  uint8_t front_ = 2;                // index of the reader's value
};

}  // namespace stillray::view
