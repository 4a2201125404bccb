// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Process-wide counts of image memory: planes on the CPU, images and buffers on devices. A block
/// is a single allocation from the system or the driver; allocations lie in blocks; the ranges of a
/// block outside its allocations are unused.
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

/// Counts the blocks of an owner until RemoveBlocks. Thread-safe, as all functions of this file.
/// \param owner  unique among the counted owners
/// \throws std::bad_alloc
void CountBlocks(const void* owner, MemoryPlace place, const MemoryBlocks& blocks);
/// No effect for an owner that is not counted.
void RemoveBlocks(const void* owner);

/// The sum over all owners.
MemoryBlocks CountedBlocks(MemoryPlace place);

}  // namespace stillray
