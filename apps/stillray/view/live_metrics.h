// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Computes image metrics against the reference on a separate thread, at the highest possible rate.
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

  /// Copies the images and measures them, unless an earlier measurement is still running.
  void Offer(const Image3& denoised, const Image3& noisy, const Image3& reference,
             int reference_spp);
  /// The latest result; none after Forget() until the next measurement.
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
  std::thread thread_;  // last member, since it uses the members above
};

}  // namespace stillray::view
