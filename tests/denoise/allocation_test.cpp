// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Counts allocations while frames are denoised: there must be none after the first frames.
#include <atomic>
#include <cstdlib>
#include <new>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "stillray/denoise.hpp"
#include "test_frames.h"

namespace {

std::atomic<int64_t> allocations = 0;

[[gnu::noinline]] void* Allocate(size_t bytes, size_t alignment) {
  ++allocations;
  const size_t rounded = (bytes + alignment - 1) / alignment * alignment;
  void* memory = std::aligned_alloc(alignment, rounded == 0 ? alignment : rounded);
  if (memory == nullptr) {
    throw std::bad_alloc();
  }
  return memory;
}

}  // namespace

void* operator new(size_t bytes) {
  return Allocate(bytes, alignof(std::max_align_t));
}
void* operator new(size_t bytes, std::align_val_t alignment) {
  return Allocate(bytes, static_cast<size_t>(alignment));
}
void operator delete(void* memory) noexcept {
  std::free(memory);
}
void operator delete(void* memory, size_t) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::align_val_t) noexcept {
  std::free(memory);
}
void operator delete(void* memory, size_t, std::align_val_t) noexcept {
  std::free(memory);
}

namespace stillray {
namespace {

/// Allocations of each of the frames after `first`.
int64_t CountSteady(const Settings& settings, bool sparse, int first) {
  // With several threads one of them may do its first work, and make room for it, in any frame.
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  Denoiser denoiser = std::move(Denoiser::Create(settings).value());
  DenoisedFrame out;
  int64_t steady = 0;
  for (int i = 0; i < first + 3; ++i) {
    Frame frame = test::MakeBusyFrame(70, 50, i);
    if (sparse) {
      frame.samples = Image1(frame.width, frame.height);
      for (int y = 0; y < frame.height; ++y) {
        for (int x = 0; x < frame.width; ++x) {
          frame.samples(x, y) = (x + 3 * y + i) % 4 == 0 ? 1.0f : 0.0f;
        }
      }
    }
    const int64_t before = allocations;
    EXPECT_TRUE(denoiser.Denoise(frame, &out).ok());
    steady += i >= first ? allocations - before : 0;
  }
  return steady;
}

TEST(Allocation, CountsAtAll) {
  const int64_t before = allocations;
  const Image1 plane(8, 8);
  EXPECT_GT(allocations, before);
}

TEST(Allocation, NoneInTheSteadyState) {
  for (const std::string_view preset : PresetNames()) {
    const Settings settings = PresetSettings(preset).value();
    EXPECT_EQ(CountSteady(settings, false, 4), 0) << preset;
    EXPECT_EQ(CountSteady(settings, true, 9), 0) << preset << ", a quarter of the pixels";
  }
}

TEST(Allocation, NoneWithAnyGroupingOrFireflies) {
  for (const char* grouping : {"single", "direct_indirect", "diffuse_specular", "channels"}) {
    for (const char* firefly : {"off", "clamp", "compress"}) {
      Settings settings;
      EXPECT_TRUE(SetParameter(&settings, "signals", grouping).ok());
      EXPECT_TRUE(SetParameter(&settings, "firefly", firefly).ok());
      EXPECT_EQ(CountSteady(settings, false, 4), 0) << grouping << " " << firefly;
    }
  }
}

}  // namespace
}  // namespace stillray
