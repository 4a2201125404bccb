// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Prefetches the next row of many planes while the present row is processed. Stages read more
/// planes than hardware prefetchers can track; without these prefetches they mostly wait for memory
/// (the wavelet of three signals took two to three times as long).
#pragma once

#include <cstddef>

#include "stillray/image.h"

namespace stillray {

/// \tparam kMost  capacity in planes
template <size_t kMost>
class NextRow {
 public:
  /// Adds the row of a plane that is read or written next; rows outside the plane are ignored.
  template <typename T>
  void Add(const Plane<T>& plane, int y) {
    static_assert(sizeof(T) == kBytes);
    if (!plane.empty() && y >= -plane.border() && y < plane.height() + plane.border()) {
      rows_[count_++] = reinterpret_cast<const char*>(plane.Row(y));
    }
  }
  template <typename T, int N, typename Basis>
  void Add(const Planes<T, N, Basis>& planes, int y) {
    for (const Plane<T>& plane : planes.channel) {
      Add(plane, y);
    }
  }

  /// Must be called for every vector of the present row.
  /// \param x  first pixel of the vector
  void Fetch(int x) const {
    for (size_t i = 0; i < count_; ++i) {
      __builtin_prefetch(rows_[i] + static_cast<ptrdiff_t>(x) * kBytes, 0, 2);
    }
  }

 private:
  static constexpr ptrdiff_t kBytes = 4;
  const char* rows_[kMost];
  size_t count_ = 0;
};

}  // namespace stillray
