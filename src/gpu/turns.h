// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// A lock whose users have their turn in the order in which they asked. Who gives an ordinary mutex
/// back and takes it again at once, as a tracer does between its submissions, mostly is faster than
/// whoever waits for it.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <mutex>

namespace stillray::gpu {

class Turns {
 public:
  void lock() {
    std::unique_lock<std::mutex> guard(mutex_);
    const uint64_t mine = next_++;
    changed_.wait(guard, [&] { return served_ == mine; });
  }
  void unlock() {
    {
      const std::lock_guard<std::mutex> guard(mutex_);
      ++served_;
    }
    changed_.notify_all();
  }
  /// Users that have the lock or wait for it.
  uint64_t users() const {
    const std::lock_guard<std::mutex> guard(mutex_);
    return next_ - served_;
  }

 private:
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  uint64_t next_ = 0;    ///< number of who asks next
  uint64_t served_ = 0;  ///< number of who has the lock
};

using Turn = std::unique_lock<Turns>;

}  // namespace stillray::gpu
