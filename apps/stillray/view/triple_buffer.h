// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// One writer, one reader, three values: neither ever waits for the other's work.
#pragma once

#include <array>
#include <mutex>
#include <utility>

namespace stillray::view {

template <typename T>
class TripleBuffer {
 public:
  /// The writer's value: what it holds is left over from an earlier one.
  T& back() { return values_[back_]; }
  /// Hands the writer's value over; one that was not read yet is dropped.
  void Publish() {
    const std::lock_guard lock(mutex_);
    std::swap(back_, middle_);
    fresh_ = true;
  }
  /// The newest value, if there is one that the reader has not seen; valid until the next call.
  const T* Take() {
    const std::lock_guard lock(mutex_);
    if (!fresh_) {
      return nullptr;
    }
    std::swap(front_, middle_);
    fresh_ = false;
    return &values_[front_];
  }

 private:
  std::array<T, 3> values_;
  std::mutex mutex_;  // held for swaps of numbers alone
  size_t back_ = 0;
  size_t middle_ = 1;
  size_t front_ = 2;
  bool fresh_ = false;
};

}  // namespace stillray::view
