// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// A FIFO mutex. With std::mutex, a thread that immediately relocks, like the path tracer between
/// submissions, starves the waiting threads.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <mutex>

namespace stillray::gpu {

class FairMutex {
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
  /// Number of threads that hold the lock or wait for it.
  uint64_t users() const {
    const std::lock_guard<std::mutex> guard(mutex_);
    return next_ - served_;
  }

 private:
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  uint64_t next_ = 0;    ///< ticket of the next thread to wait
  uint64_t served_ = 0;  ///< ticket of the thread that holds the lock
};

using FairLock = std::unique_lock<FairMutex>;

}  // namespace stillray::gpu
