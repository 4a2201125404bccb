// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Counts of the memory that holds pictures: planes on the CPU, images and buffers on devices. They
/// are of the whole process. A block is what the system or the driver has given at once;
/// allocations lie in blocks; ranges of a block between, before and behind its allocations are
/// unused.
#pragma once

#include <cstddef>
#include <cstdint>

namespace stillray {

struct MemoryBlocks {
  uint64_t blocks = 0;
  uint64_t allocations = 0;
  uint64_t block_bytes = 0;
  uint64_t allocated_bytes = 0;
  uint64_t unused_ranges = 0;
  // Bytes; 0 if there is none.
  uint64_t smallest_allocation = 0;
  uint64_t largest_allocation = 0;
  uint64_t smallest_unused = 0;
  uint64_t largest_unused = 0;

  void AddAllocation(uint64_t bytes);
  /// No effect if `bytes` is 0.
  void AddUnused(uint64_t bytes);
  MemoryBlocks& operator+=(const MemoryBlocks& other);
  bool operator==(const MemoryBlocks&) const = default;
};

enum class MemoryPlace : uint8_t { kHost, kDevice };

/// Counts the blocks of an owner until RemoveBlocks. Thread-safe, as all functions here.
/// \param owner  unique among the owners that are counted
/// \throws std::bad_alloc
void CountBlocks(const void* owner, MemoryPlace place, const MemoryBlocks& blocks);
/// No effect for an owner that is not counted.
void RemoveBlocks(const void* owner);

/// The sum over all owners.
MemoryBlocks CountedBlocks(MemoryPlace place);

}  // namespace stillray
