// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "core/memory_blocks.h"

#include <algorithm>
#include <mutex>
#include <unordered_map>

namespace stillray {
namespace {

/// The smaller of two sizes, where 0 means no size.
uint64_t SmallerOf(uint64_t a, uint64_t b) {
  return a == 0 || b == 0 ? std::max(a, b) : std::min(a, b);
}

struct Owner {
  MemoryPlace place;
  MemoryBlocks blocks;
};

struct Registry {
  std::mutex mutex;
  std::unordered_map<const void*, Owner> owners;
};

/// Never destroyed: planes of static storage may be freed after everything else.
Registry& Counted() {
  static auto* registry = new Registry;
  return *registry;
}

}  // namespace

void MemoryBlocks::AddAllocation(uint64_t bytes) {
  ++allocations;
  allocated_bytes += bytes;
  smallest_allocation = SmallerOf(smallest_allocation, bytes);
  largest_allocation = std::max(largest_allocation, bytes);
}

void MemoryBlocks::AddUnused(uint64_t bytes) {
  unused_ranges += bytes > 0 ? 1 : 0;
  smallest_unused = SmallerOf(smallest_unused, bytes);
  largest_unused = std::max(largest_unused, bytes);
}

MemoryBlocks& MemoryBlocks::operator+=(const MemoryBlocks& other) {
  blocks += other.blocks;
  allocations += other.allocations;
  block_bytes += other.block_bytes;
  allocated_bytes += other.allocated_bytes;
  unused_ranges += other.unused_ranges;
  smallest_allocation = SmallerOf(smallest_allocation, other.smallest_allocation);
  largest_allocation = std::max(largest_allocation, other.largest_allocation);
  smallest_unused = SmallerOf(smallest_unused, other.smallest_unused);
  largest_unused = std::max(largest_unused, other.largest_unused);
  return *this;
}

void CountBlocks(const void* owner, MemoryPlace place, const MemoryBlocks& blocks) {
  Registry& registry = Counted();
  const std::lock_guard<std::mutex> lock(registry.mutex);
  registry.owners.insert_or_assign(owner, Owner{place, blocks});
}

void RemoveBlocks(const void* owner) {
  Registry& registry = Counted();
  const std::lock_guard<std::mutex> lock(registry.mutex);
  registry.owners.erase(owner);
}

MemoryBlocks CountedBlocks(MemoryPlace place) {
  Registry& registry = Counted();
  const std::lock_guard<std::mutex> lock(registry.mutex);
  MemoryBlocks sum;
  for (const auto& [key, owner] : registry.owners) {
    if (owner.place == place) {
      sum += owner.blocks;
    }
  }
  return sum;
}

}  // namespace stillray
