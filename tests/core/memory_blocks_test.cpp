// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "core/memory_blocks.h"

#include <utility>

#include <gtest/gtest.h>

#include "stillray/image.h"

namespace stillray::memory_blocks_test {
namespace {

TEST(MemoryBlocks, SumsByHand) {
  MemoryBlocks a;
  a.blocks = 1;
  a.block_bytes = 100;
  a.AddAllocation(40);
  a.AddAllocation(30);
  a.AddUnused(0);
  a.AddUnused(20);
  a.AddUnused(10);
  EXPECT_EQ(a.allocations, 2u);
  EXPECT_EQ(a.allocated_bytes, 70u);
  EXPECT_EQ(a.unused_ranges, 2u);
  EXPECT_EQ(a.smallest_allocation, 30u);
  EXPECT_EQ(a.largest_allocation, 40u);
  EXPECT_EQ(a.smallest_unused, 10u);
  EXPECT_EQ(a.largest_unused, 20u);
  MemoryBlocks b;
  b.blocks = 2;
  b.block_bytes = 8;
  b.AddAllocation(8);
  MemoryBlocks sum = a;
  sum += b;
  EXPECT_EQ(sum.blocks, 3u);
  EXPECT_EQ(sum.block_bytes, 108u);
  EXPECT_EQ(sum.allocations, 3u);
  EXPECT_EQ(sum.allocated_bytes, 78u);
  EXPECT_EQ(sum.smallest_allocation, 8u);
  EXPECT_EQ(sum.smallest_unused, 10u);  // b has no unused range
  sum = MemoryBlocks();
  sum += a;
  EXPECT_EQ(sum, a);
}

TEST(MemoryBlocks, OwnersAreCountedUntilTheyAreRemoved) {
  const MemoryBlocks before = CountedBlocks(MemoryPlace::kDevice);
  MemoryBlocks own;
  own.blocks = 1;
  own.AddAllocation(64);
  const int owner = 0;
  CountBlocks(&owner, MemoryPlace::kDevice, own);
  EXPECT_EQ(CountedBlocks(MemoryPlace::kDevice).blocks, before.blocks + 1);
  CountBlocks(&owner, MemoryPlace::kDevice, own);  // again: in place of the first
  EXPECT_EQ(CountedBlocks(MemoryPlace::kDevice).allocated_bytes, before.allocated_bytes + 64);
  RemoveBlocks(&owner);
  RemoveBlocks(&owner);
  EXPECT_EQ(CountedBlocks(MemoryPlace::kDevice), before);
}

// Every plane is one allocation in a block of its own; blocks are complete: what is allocated and
// what is not add up to them.
TEST(MemoryBlocks, PlanesAreCountedWhileTheyLive) {
  const MemoryBlocks before = CountedBlocks(MemoryPlace::kHost);
  {
    Image1 small(16, 16);
    Image1 large(1024, 1024);
    const MemoryBlocks with = CountedBlocks(MemoryPlace::kHost);
    EXPECT_EQ(with.blocks, before.blocks + 2);
    EXPECT_EQ(with.allocations, before.allocations + 2);
    EXPECT_GE(with.allocated_bytes, before.allocated_bytes + 4 * (256 + 1024 * 1024));
    EXPECT_GE(with.block_bytes - with.allocated_bytes, before.block_bytes - before.allocated_bytes);
    EXPECT_GE(with.largest_allocation, 4u * 1024 * 1024);
    const Image1 moved = std::move(large);
    EXPECT_EQ(CountedBlocks(MemoryPlace::kHost), with);
    const Image1 copy = small;
    EXPECT_EQ(CountedBlocks(MemoryPlace::kHost).allocations, with.allocations + 1);
  }
  EXPECT_EQ(CountedBlocks(MemoryPlace::kHost), before);
}

}  // namespace
}  // namespace stillray::memory_blocks_test
