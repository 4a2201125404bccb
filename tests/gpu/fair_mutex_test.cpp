// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "gpu/fair_mutex.h"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>
#include <vector>

namespace stillray::gpu::fair_mutex_test {
namespace {

/// Until so many have the lock or wait for it.
void WaitForUsers(const FairMutex& mutex, uint64_t users) {
  while (mutex.users() < users) {
    std::this_thread::yield();
  }
}

TEST(FairMutex, LocksInTheOrderOfRequests) {
  FairMutex mutex;
  std::vector<int> order;
  std::vector<std::thread> threads;
  {
    const FairLock first(mutex);
    for (int i = 0; i < 4; ++i) {
      threads.emplace_back([&, i] {
        const FairLock mine(mutex);
        order.push_back(i);
      });
      WaitForUsers(mutex, static_cast<uint64_t>(i) + 2);
    }
    EXPECT_TRUE(order.empty());
  }
  for (std::thread& thread : threads) {
    thread.join();
  }
  EXPECT_EQ(order, (std::vector<int>{0, 1, 2, 3}));
}

TEST(FairMutex, AThreadThatLocksAgainWaitsForTheOthers) {
  FairMutex mutex;
  std::atomic<bool> had_turn = false;
  FairLock busy(mutex);
  std::thread other([&] {
    const FairLock mine(mutex);
    had_turn = true;
  });
  WaitForUsers(mutex, 2);
  EXPECT_FALSE(had_turn);
  busy.unlock();
  busy.lock();
  EXPECT_TRUE(had_turn);
  busy.unlock();
  other.join();
}

}  // namespace
}  // namespace stillray::gpu::fair_mutex_test
