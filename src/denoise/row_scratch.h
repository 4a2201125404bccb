// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Per-thread work memory for a few rows.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace stillray {

/// Rows of 4-byte values for loops over whole rows; aligned to cache lines, so that no vector
/// crosses two. The storage belongs to the thread and only grows: at most one object may exist per
/// thread, and rows are not cleared.
class RowScratch {
 public:
  /// \param width  of the rows; kRoom more lines may be read and written before and after
  RowScratch(int width, int rows)
      : stride_(static_cast<size_t>(width) / kLineValues + 1 + 2 * kRoom) {
    std::vector<Line>& storage = Storage();
    const size_t lines = stride_ * static_cast<size_t>(rows);
    if (storage.size() < lines) {
      storage.resize(lines);
    }
    first_ = storage.data() + kRoom;
  }
  template <typename T = float>
  T* Row(int i) const {
    static_assert(sizeof(T) == kValue);
    return reinterpret_cast<T*>(first_ + stride_ * static_cast<size_t>(i));
  }

 private:
  static constexpr size_t kValue = 4;
  static constexpr size_t kLineValues = 16;
  struct alignas(kValue* kLineValues) Line {
    std::byte bytes[kValue * kLineValues];
  };
  /// In lines: three of the widest vectors, and one for rounding.
  static constexpr size_t kRoom = 4;
  static std::vector<Line>& Storage() {
    static thread_local std::vector<Line> storage;
    return storage;
  }

  size_t stride_;  ///< in lines
  Line* first_;
};

}  // namespace stillray
