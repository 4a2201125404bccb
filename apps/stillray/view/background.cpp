// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "view/background.h"

#ifdef __linux__
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>
#endif

#include <tbb/task_scheduler_observer.h>

namespace stillray::view {
namespace {

void LowerPriority() {
#ifdef __linux__
  // Linux gives each thread its own nice value. At 5 it gets a third of what a thread at 0 gets
  // while both want the same processor, and all of it otherwise.
  constexpr int kNice = 5;
  const auto thread = static_cast<id_t>(syscall(SYS_gettid));
  if (getpriority(PRIO_PROCESS, thread) < kNice) {
    setpriority(PRIO_PROCESS, thread, kNice);
  }
#endif
}

}  // namespace

struct BackgroundWork::Observer : tbb::task_scheduler_observer {
  void on_scheduler_entry(bool is_worker) override {
    thread_local bool lowered = false;
    if (is_worker && !lowered) {
      LowerPriority();
      lowered = true;
    }
  }
};

BackgroundWork::BackgroundWork() : observer_(std::make_unique<Observer>()) {
  LowerPriority();
  observer_->observe(true);
}

BackgroundWork::~BackgroundWork() {
  observer_->observe(false);
}

}  // namespace stillray::view
