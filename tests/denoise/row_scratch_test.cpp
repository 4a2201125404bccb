// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/row_scratch.h"

#include <algorithm>
#include <cstdint>

#include <gtest/gtest.h>

namespace stillray::row_scratch_test {
namespace {

/// Three of the widest vectors: loops may access as many values before and after a row.
constexpr int kAround = 48;

TEST(RowScratch, RowsBeginAtACacheLine) {
  for (const int width : {1, 15, 16, 17, 1366}) {
    const RowScratch scratch(width, 3);
    for (int i = 0; i < 3; ++i) {
      EXPECT_EQ(reinterpret_cast<uintptr_t>(scratch.Row(i)) % 64, 0u) << width << ", row " << i;
    }
  }
}

TEST(RowScratch, HasRoomAroundEveryRow) {
  for (const int width : {1, 15, 16, 17, 1366}) {
    const RowScratch scratch(width, 3);
    const int rounded = (width + 15) / 16 * 16;
    for (int i = 0; i < 3; ++i) {  // the sanitizer detects access beyond
      std::fill(scratch.Row(i) - kAround, scratch.Row(i) + rounded + kAround,
                static_cast<float>(i + 1));
    }
    for (int i = 0; i < 3; ++i) {
      EXPECT_EQ(*std::min_element(scratch.Row(i), scratch.Row(i) + width), i + 1.0f);
      EXPECT_EQ(*std::max_element(scratch.Row(i), scratch.Row(i) + width), i + 1.0f);
    }
  }
}

}  // namespace
}  // namespace stillray::row_scratch_test
