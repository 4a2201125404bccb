// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Measures pictures against the reference on a separate thread, as often as it can.
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

  /// Copies the pictures and measures them, unless the previous ones are still being measured.
  void Offer(const Image3& denoised, const Image3& noisy, const Image3& reference,
             int reference_spp);
  /// The last result; none between Forget() and the next one.
  std::optional<LiveMeasures> latest() const;
  /// Discards results and running measurements, because the view has changed.
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
  std::thread thread_;  // last, since it uses the members above
};

}  // namespace stillray::view
