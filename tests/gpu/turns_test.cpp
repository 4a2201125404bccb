// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "gpu/turns.h"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>
#include <vector>

namespace stillray::gpu {
namespace {

/// Until so many have the lock or wait for it.
void WaitForUsers(const Turns& turns, uint64_t users) {
  while (turns.users() < users) {
    std::this_thread::yield();
  }
}

TEST(TurnsTest, ComeInTheOrderOfAsking) {
  Turns turns;
  std::vector<int> order;
  std::vector<std::thread> threads;
  {
    const Turn first(turns);
    for (int i = 0; i < 4; ++i) {
      threads.emplace_back([&, i] {
        const Turn mine(turns);
        order.push_back(i);
      });
      WaitForUsers(turns, static_cast<uint64_t>(i) + 2);
    }
    EXPECT_TRUE(order.empty());
  }
  for (std::thread& thread : threads) {
    thread.join();
  }
  EXPECT_EQ(order, (std::vector<int>{0, 1, 2, 3}));
}

TEST(TurnsTest, WhoComesAgainAtOnceWaitsForTheOthers) {
  Turns turns;
  std::atomic<bool> had_turn = false;
  Turn busy(turns);
  std::thread other([&] {
    const Turn mine(turns);
    had_turn = true;
  });
  WaitForUsers(turns, 2);
  EXPECT_FALSE(had_turn);
  busy.unlock();
  busy.lock();
  EXPECT_TRUE(had_turn);
  busy.unlock();
  other.join();
}

}  // namespace
}  // namespace stillray::gpu
