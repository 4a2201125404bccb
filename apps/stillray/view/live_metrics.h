// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Measures pictures against the reference on a thread of its own, as fast as it can keep up.
#pragma once

#include <condition_variable>
#include <mutex>
#include <optional>
#include <thread>

#include "stillray/image.h"
#include "view/view_frame.h"

namespace stillray::view {

class LiveMetrics {
 public:
  LiveMetrics();
  ~LiveMetrics();

  /// Takes copies and measures them, unless it is still busy with the last ones.
  void Offer(const Image3& denoised, const Image3& noisy, const Image3& reference,
             int reference_spp);
  /// The last result; none after Forget() until there is a new one.
  std::optional<LiveMeasures> latest() const;
  /// What is known or being measured is of another view.
  void Forget();

 private:
  struct Job {
    Image3 denoised;
    Image3 noisy;
    Image3 reference;
    int spp = 0;
    uint64_t epoch = 0;
  };
  void Run();

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::optional<Job> job_;
  bool busy_ = false;
  bool stop_ = false;
  uint64_t epoch_ = 0;
  std::optional<LiveMeasures> latest_;
  std::thread thread_;  // last: it uses everything above
};

}  // namespace stillray::view
