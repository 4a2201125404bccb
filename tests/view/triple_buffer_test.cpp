// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "view/triple_buffer.h"

#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace stillray::view::triple_buffer_test {
namespace {

TEST(TripleBuffer, HandsEveryValueOverOnce) {
  TripleBuffer<int> buffer;
  EXPECT_EQ(buffer.Take(), nullptr);
  buffer.back() = 1;
  buffer.Publish();
  ASSERT_NE(buffer.Take(), nullptr);
  EXPECT_EQ(buffer.Take(), nullptr);
}

TEST(TripleBuffer, TheNewestWins) {
  TripleBuffer<int> buffer;
  for (int i = 1; i <= 5; ++i) {
    buffer.back() = i;
    buffer.Publish();
  }
  EXPECT_EQ(*buffer.Take(), 5);
}

TEST(TripleBuffer, ReaderSeesWholeValuesInOrder) {
  struct Pair {
    int a = 0;
    int b = 0;
  };
  constexpr int kCount = 20000;
  TripleBuffer<Pair> buffer;
  std::thread writer([&] {
    for (int i = 1; i <= kCount; ++i) {
      buffer.back() = {i, -i};
      buffer.Publish();
    }
  });
  int last = 0;
  while (last < kCount) {
    if (const Pair* pair = buffer.Take(); pair != nullptr) {
      ASSERT_EQ(pair->a, -pair->b);
      ASSERT_GT(pair->a, last);
      last = pair->a;
    }
  }
  writer.join();
}

}  // namespace
}  // namespace stillray::view::triple_buffer_test
