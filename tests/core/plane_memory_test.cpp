// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <cstdint>
#include <set>
#include <vector>

#include <gtest/gtest.h>

#include "stillray/image.h"

namespace stillray::plane_memory_test {
namespace {

/// Places in a memory page at which planes of that size begin.
size_t Places(int count, int width, int height) {
  std::vector<Image1> planes;
  std::set<uintptr_t> places;
  for (int i = 0; i < count; ++i) {
    planes.emplace_back(width, height);
    places.insert(reinterpret_cast<uintptr_t>(planes.back().Row(0)) % 4096);
  }
  return places.size();
}

// Otherwise all planes of a stage would use the same L1 sets, and its writes would evict its reads.
TEST(PlaneMemory, PlanesBeginAtDifferentPlacesOfAPage) {
  EXPECT_EQ(Places(40, 1280, 720), 40u);
}

TEST(PlaneMemory, RowsBeginOnCacheLines) {
  for (const int width : {1, 17, 640, 1280}) {
    const Image1 plane(width, 3, 5);
    for (int y = -5; y < 8; ++y) {
      EXPECT_EQ(reinterpret_cast<uintptr_t>(plane.Row(y)) % Image1::kAlignment, 0u);
    }
  }
}

TEST(PlaneMemory, IsZeroWhenMade) {
  for (const int height : {3, 1500}) {  // in small and in huge pages
    const Image1 plane(700, height, 2);
    for (int y = -2; y < height + 2; ++y) {
      for (int x = -2; x < 702; ++x) {
        ASSERT_EQ(plane(x, y), 0.0f) << x << ", " << y;
      }
    }
  }
}

}  // namespace
}  // namespace stillray::plane_memory_test
