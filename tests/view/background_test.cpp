// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "view/background.h"

#ifdef __linux__
#include <sys/resource.h>
#endif

#include <algorithm>
#include <atomic>
#include <set>
#include <thread>

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>

// TBB's own note of an observer stays with a worker that sleeps when the program ends.
extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() {
  return "leak:tbb::detail::r1::observe\n";
}

namespace stillray::view::background_test {
namespace {

#ifdef __linux__

/// Threads of the pool are made by a thread whose priority is lowered already, and inherit that.
TEST(Background, EveryThreadIsLoweredOnce) {
  const int own = getpriority(PRIO_PROCESS, 0);
  const tbb::global_control two(tbb::global_control::max_allowed_parallelism, 2);
  std::set<int> seen[2];
  std::thread([&] {
    const BackgroundWork background;
    std::atomic<int> arrived = 0;
    tbb::parallel_for(
        0, 2,
        [&](int i) {
          // Each thread waits for the other one: both take part.
          ++arrived;
          while (arrived < 2) {
            std::this_thread::yield();
          }
          seen[i].insert(getpriority(PRIO_PROCESS, 0));
        },
        tbb::simple_partitioner());
  }).join();
  const std::set<int> expected = {std::min(own + 10, 19)};
  EXPECT_EQ(seen[0], expected);
  EXPECT_EQ(seen[1], expected);
  EXPECT_EQ(getpriority(PRIO_PROCESS, 0), own) << "the thread of the interface keeps its own";
}

#endif

}  // namespace
}  // namespace stillray::view::background_test
