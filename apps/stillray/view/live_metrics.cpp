// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "view/live_metrics.h"

#include <tbb/task_arena.h>

#include "stillray/quality.h"
#include "view/background.h"

namespace stillray::view {

LiveMetrics::LiveMetrics() : thread_([this] { Run(); }) {}

LiveMetrics::~LiveMetrics() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void LiveMetrics::Offer(const Image3& denoised, const Image3& noisy, const Image3& reference,
                        int reference_spp) {
  {
    const std::lock_guard lock(mutex_);
    if (busy_ || job_) {
      return;
    }
    job_ = Job{denoised, noisy, reference, reference_spp, epoch_};
  }
  changed_.notify_all();
}

std::optional<LiveMeasures> LiveMetrics::latest() const {
  const std::lock_guard lock(mutex_);
  return latest_;
}

void LiveMetrics::Forget() {
  const std::lock_guard lock(mutex_);
  ++epoch_;
  latest_.reset();
}

void LiveMetrics::Run() {
  const BackgroundWork background;
  // A single thread, since frames have priority.
  tbb::task_arena arena(1);
  while (true) {
    Job job;
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [&] { return stop_ || job_; });
      if (stop_) {
        return;
      }
      job = std::move(*job_);
      job_.reset();
      busy_ = true;
    }
    std::optional<LiveMeasures> result;
    arena.execute([&] {
      const Result<ImageMetrics> denoised = CompareImages(job.denoised, job.reference, false);
      const Result<ImageMetrics> noisy = CompareImages(job.noisy, job.reference, false);
      if (denoised.ok() && noisy.ok()) {
        result = LiveMeasures{denoised.value(), noisy.value(), job.spp};
      }
    });
    const std::lock_guard lock(mutex_);
    busy_ = false;
    if (result && job.epoch == epoch_) {
      latest_ = result;
    }
  }
}

}  // namespace stillray::view
