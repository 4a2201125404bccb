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
  // Linux gives each thread a nice value of its own, and a new thread that of its maker: pool
  // threads made by a thread that is lowered already are so from their start. The value is
  // therefore set, not added. Ten steps below the program's own: a ninth of what a thread of the
  // interface gets while both want the same processor, and all of it otherwise.
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
