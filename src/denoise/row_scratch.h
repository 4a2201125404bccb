// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// A few rows of work for the thread that asks.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace stillray {

/// Rows of 4-byte values for loops that work on whole rows. The storage belongs to the thread and
/// grows once; so only one of these may be alive in a thread, and rows hold what was left in them.
class RowScratch {
 public:
  /// \param width  of the rows; kRoom values more may be read and written before and after
  RowScratch(int width, int rows) : stride_(static_cast<size_t>(width) + 2 * kRoom) {
    std::vector<std::byte>& storage = Storage();
    const size_t bytes = kValue * stride_ * static_cast<size_t>(rows);
    if (storage.size() < bytes) {
      storage.resize(bytes);
    }
    first_ = storage.data() + kValue * kRoom;
  }
  template <typename T = float>
  T* Row(int i) const {
    static_assert(sizeof(T) == kValue);
    return reinterpret_cast<T*>(first_ + kValue * stride_ * static_cast<size_t>(i));
  }

 private:
  static constexpr size_t kValue = 4;
  /// Three of the widest vectors, and what rounding to them adds.
  static constexpr size_t kRoom = 64;
  static std::vector<std::byte>& Storage() {
    static thread_local std::vector<std::byte> storage;
    return storage;
  }

  size_t stride_;
  std::byte* first_;
};

}  // namespace stillray
