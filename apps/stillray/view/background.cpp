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
  // On Linux each thread has its own nice value, and a new thread inherits it: pool threads created
  // by a thread with a raised value start with it. The value is therefore set, not added. Ten steps
  // above the program's value: the thread gets a ninth of an interface thread's time if both
  // compete for a processor, and the full processor otherwise.
  constexpr int kSteps = 10;
  constexpr int kLast = 19;
  static const int kLowered = std::min(getpriority(PRIO_PROCESS, 0) + kSteps, kLast);
  thread_local bool lowered = false;
  if (!lowered) {
    lowered = true;
    setpriority(PRIO_PROCESS, static_cast<id_t>(syscall(SYS_gettid)), kLowered);
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
