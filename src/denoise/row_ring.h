// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Rows that are read again soon after they were written: a few of them, used in turn, so that they
/// stay in the caches and never go to memory.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <vector>

#include "stillray/image.h"

namespace stillray {

/// Where the rows of a plane lie, or those of a ring: there, every row has the place of the one
/// `period` before it.
template <typename T>
struct PlaneRows {
  T* first = nullptr;    ///< row 0
  ptrdiff_t stride = 0;  ///< values
  int period = 0;        ///< 0: a plane, which keeps all rows

  PlaneRows() = default;
  PlaneRows(T* first_row, ptrdiff_t row_stride, int rows)
      : first(first_row), stride(row_stride), period(rows) {}
  /// All rows of a plane.
  explicit PlaneRows(Plane<std::remove_const_t<T>>& plane)
      : first(plane.Row(0)), stride(plane.stride()) {}
  explicit PlaneRows(const Plane<std::remove_const_t<T>>& plane) requires(std::is_const_v<T>)
      : first(plane.Row(0)), stride(plane.stride()) {}
  /// For reading alone.
  operator PlaneRows<const T>() const requires(!std::is_const_v<T>) {
    return {first, stride, period};
  }

  bool empty() const { return first == nullptr; }
  bool is_ring() const { return period > 0; }
  /// \param y  of a ring, >= -period
  T* Row(int y) const { return first + (is_ring() ? (y + period) % period : y) * stride; }
};

/// The rings of one thread. They are made of memory that it keeps, so that nothing is allocated in
/// the steady state; one object at a time may use it.
class RowRings {
 public:
  /// \param width   of the rows
  /// \param border  values before and after each row, which are zero
  /// \param rows    of all rings together
  RowRings(int width, int border, int rows)
      : left_(RoundUp(border)),
        stride_(left_ + RoundUp(width + border) + kLine),
        border_(border),
        width_(width) {
    const size_t count = static_cast<size_t>(stride_) * static_cast<size_t>(rows) + kLine;
    std::vector<float>& storage = Storage();
    if (storage.size() < count) {
      storage.resize(count);
    }
    const auto address = reinterpret_cast<uintptr_t>(storage.data());
    next_ = storage.data() + (-address % (kLine * sizeof(float))) / sizeof(float);
  }
  /// The next ring.
  PlaneRows<float> Add(int rows) {
    const PlaneRows<float> ring(next_ + left_, stride_, rows);
    for (int y = 0; y < rows; ++y) {
      std::fill(ring.Row(y) - border_, ring.Row(y), 0.0f);
      std::fill(ring.Row(y) + width_, ring.Row(y) + width_ + border_, 0.0f);
    }
    next_ += stride_ * rows;
    return ring;
  }

 private:
  static constexpr int kLine = 16;  ///< values of a cache line
  static ptrdiff_t RoundUp(int value) { return (value + kLine - 1) / kLine * kLine; }
  static std::vector<float>& Storage() {
    static thread_local std::vector<float> storage;
    return storage;
  }

  ptrdiff_t left_;
  ptrdiff_t stride_;
  int border_;
  int width_;
  float* next_;
};

}  // namespace stillray
