// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The address sanitizer checks the bounds of heap blocks only, so under it large planes are not
// mapped.
#if defined(__linux__) && !defined(__SANITIZE_ADDRESS__)
#define STILLRAY_MAPS_PLANES 1
#if defined(__has_feature)
#if __has_feature(address_sanitizer)
#undef STILLRAY_MAPS_PLANES
#endif
#endif
#endif

#ifdef STILLRAY_MAPS_PLANES
#include <sys/mman.h>
#endif

#include <atomic>
#include <new>

#include "core/memory_blocks.h"
#include "stillray/image.h"

namespace stillray::detail {
namespace {

/// Successive planes cycle through this many different offsets.
constexpr size_t kPlaces = 64;

/// Large and small planes are counted separately: a stage reads many planes of one size, and small
/// planes allocated in between would else give two of them the same offset.
size_t NextPlace(bool large) {
  static std::atomic<uint32_t> made[2] = {};
  return made[large ? 1 : 0].fetch_add(1, std::memory_order_relaxed) % kPlaces;
}

/// Offset from the start of a memory page, different for each index. Planes of a stage with the
/// same offset map to the same L1 sets, where writes to one evict reads of another (three signals
/// of the wavelet took 1.7 times as long).
size_t SmallShift(size_t place) {
  constexpr size_t kSmallPage = 4096;
  // an odd number of cache lines, which visits every line of a page
  constexpr size_t kStep = 23 * 64;
  return place * kStep % kSmallPage;
}

#ifdef STILLRAY_MAPS_PLANES

constexpr size_t kHugePage = size_t{1} << 21;
/// Within huge pages L2 sets follow the address too, so large planes also differ in those bits.
size_t LargeShift(size_t place) {
  return place % 16 * 8192 + SmallShift(place);
}

constexpr size_t RoundUp(size_t bytes, size_t multiple) {
  return (bytes + multiple - 1) / multiple * multiple;
}

/// A last part of less than half a huge page would waste more memory in one than it saves.
size_t HugeBytes(size_t bytes) {
  return (bytes + kHugePage / 2) / kHugePage * kHugePage;
}

size_t MappedBytes(size_t bytes) {
  constexpr size_t kSmallPage = 4096;
  return std::max(RoundUp(bytes, kSmallPage), HugeBytes(bytes));
}

/// Maps MappedBytes for `bytes`, zeroed, aligned to a huge page.
void* Map(size_t bytes) {
  const size_t room = bytes + kHugePage;
  void* mapped = mmap(nullptr, room, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (mapped == MAP_FAILED) {
    throw std::bad_alloc();
  }
  auto* first = static_cast<std::byte*>(mapped);
  const auto address = reinterpret_cast<uintptr_t>(first);
  const size_t before = RoundUp(address, kHugePage) - address;
  if (before > 0) {
    munmap(first, before);
  }
  munmap(first + before + bytes, room - before - bytes);
  // Without huge pages the memory works all the same.
  static_cast<void>(madvise(first + before, bytes / kHugePage * kHugePage, MADV_HUGEPAGE));
  return first + before;
}

#endif  // STILLRAY_MAPS_PLANES

/// Counts a block of `bytes` with one allocation.
void Count(const void* block, size_t bytes, size_t before, size_t allocated) {
  MemoryBlocks own;
  own.blocks = 1;
  own.block_bytes = bytes;
  own.AddAllocation(allocated);
  own.AddUnused(before);
  own.AddUnused(bytes - before - allocated);
  CountBlocks(block, MemoryPlace::kHost, own);
}

}  // namespace

PlaneMemory::PlaneMemory(size_t bytes) {
  if (bytes == 0) {
    return;
  }
#ifdef STILLRAY_MAPS_PLANES
  if (bytes >= kHugePage) {
    const size_t shift = LargeShift(NextPlace(true));
    const size_t mapped = MappedBytes(bytes + shift);
    void* block = Map(mapped);
    try {
      Count(block, mapped, shift, bytes);
    } catch (...) {
      munmap(block, mapped);
      throw;
    }
    mapped_ = mapped;
    block_ = block;
    data_ = static_cast<std::byte*>(block_) + shift;
    return;
  }
#endif
  const size_t shift = SmallShift(NextPlace(false));
  void* block = ::operator new(bytes + shift, std::align_val_t(kPlaneAlignment));
  try {
    Count(block, bytes + shift, shift, bytes);
  } catch (...) {
    ::operator delete(block, std::align_val_t(kPlaneAlignment));
    throw;
  }
  block_ = block;
  data_ = static_cast<std::byte*>(block_) + shift;
  std::memset(data_, 0, bytes);
}

PlaneMemory::~PlaneMemory() {
  if (block_ != nullptr) {
    RemoveBlocks(block_);
  }
#ifdef STILLRAY_MAPS_PLANES
  if (mapped_ > 0) {
    munmap(block_, mapped_);
    return;
  }
#endif
  if (block_ != nullptr) {
    ::operator delete(block_, std::align_val_t(kPlaneAlignment));
  }
}

}  // namespace stillray::detail
