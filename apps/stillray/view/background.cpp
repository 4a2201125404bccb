// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "view/background.h"

#include <algorithm>

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
  // Linux gives each thread a nice value of its own. Ten steps: a ninth of what a thread of the
  // interface gets while both want the same processor, and all of it otherwise.
  constexpr int kSteps = 10;
  constexpr int kLast = 19;
  thread_local bool lowered = false;
  if (!lowered) {
    lowered = true;
    const auto thread = static_cast<id_t>(syscall(SYS_gettid));
    setpriority(PRIO_PROCESS, thread, std::min(getpriority(PRIO_PROCESS, thread) + kSteps, kLast));
  }
#endif
}

}  // namespace

struct BackgroundWork::Observer : tbb::task_scheduler_observer {
  void on_scheduler_entry(bool is_worker) override {
    if (is_worker) {
      LowerPriority();
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
