// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Background tasks: the next file is read and the previous one written while a frame is filtered.
#pragma once

#include <chrono>
#include <future>
#include <memory>
#include <system_error>
#include <utility>

namespace stillray {

/// Runs one task at a time; its result is fetched later. Data used by the task must live until
/// then; the destructor waits for the task. Not thread-safe.
template <typename T>
class Background {
 public:
  /// Starts `work`; no other task may be pending. With `own_thread` false, and if the system cannot
  /// create a thread, it runs in Take().
  template <typename Work>
  void Start(bool own_thread, Work work) {
    // Shared, so that the task still exists if no thread could be created for it.
    const auto shared = std::make_shared<Work>(std::move(work));
    if (own_thread) {
      try {
        result_ = std::async(std::launch::async, [shared] { return (*shared)(); });
        return;
      } catch (const std::system_error&) {
      }
    }
    result_ = std::async(std::launch::deferred, [shared] { return (*shared)(); });
  }

  /// Whether a task was started and its result has not been fetched.
  bool under_way() const { return result_.valid(); }
  /// Whether Take() returns at once.
  bool ready() const {
    return result_.valid() &&
           result_.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
  }
  /// Waits for at most this time. \return whether Take() need not wait for another thread
  bool WaitFor(std::chrono::milliseconds time) const {
    return result_.wait_for(time) != std::future_status::timeout;
  }
  /// Waits for the result. Only while under_way(). Rethrows exceptions of the task.
  T Take() { return result_.get(); }

 private:
  std::future<T> result_;
};

}  // namespace stillray
