// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Per-thread work memory for a few rows.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace stillray {

/// Rows of 4-byte values for loops over whole rows; aligned to cache lines, so that no vector
/// crosses two. The storage belongs to the thread and only grows: at most one object per `Purpose`
/// may exist in a thread, and rows are not cleared.
template <typename Purpose>
class ThreadRows {
 public:
  /// \param width  of the rows, in values; another `reach` values and kRoom lines may be read and
  ///     written before and after each row
  ThreadRows(int width, int rows, int reach = 0)
      : stride_(static_cast<size_t>(StrideOf(width, reach)) / kLineValues) {
    std::vector<Line>& storage = Storage();
    const size_t lines = stride_ * static_cast<size_t>(rows);
    if (storage.size() < lines) {
      storage.resize(lines);
    }
    first_ = lines > 0 ? storage.data() + RoomOf(reach) : nullptr;
  }
  /// In values.
  static ptrdiff_t StrideOf(int width, int reach) {
    return static_cast<ptrdiff_t>(
        (static_cast<size_t>(width) / kLineValues + 1 + 2 * RoomOf(reach)) * kLineValues);
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
  static size_t RoomOf(int reach) {
    return kRoom + (static_cast<size_t>(reach) + kLineValues - 1) / kLineValues;
  }
  static std::vector<Line>& Storage() {
    static thread_local std::vector<Line> storage;
    return storage;
  }

  size_t stride_;  ///< in lines
  Line* first_;
};

/// Work memory of a stage's row loop.
using RowScratch = ThreadRows<class AnyRows>;

}  // namespace stillray
