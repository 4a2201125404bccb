// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/row_ring.h"

#include <algorithm>
#include <cstdint>

#include <gtest/gtest.h>

namespace stillray {
namespace {

constexpr int kBorder = 5;

TEST(PlaneRows, OfAPlaneAreItsRows) {
  Image1 plane(20, 4, kBorder);
  const PlaneRows<float> rows(plane);
  const PlaneRows<const float> read = rows;
  EXPECT_FALSE(rows.is_ring());
  for (int y = -kBorder; y < 4 + kBorder; ++y) {
    EXPECT_EQ(rows.Row(y), plane.Row(y));
    EXPECT_EQ(read.Row(y), plane.Row(y));
  }
}

TEST(RowRings, GiveARowThePlaceOfTheOnePeriodBefore) {
  RowRings rings(33, kBorder, 7);
  const PlaneRows<float> ring = rings.Add(7);
  for (int y = -7; y < 20; ++y) {
    EXPECT_EQ(ring.Row(y), ring.Row(y + 7));
    for (int other = y + 1; other < y + 7; ++other) {
      EXPECT_NE(ring.Row(y), ring.Row(other));
    }
  }
}

TEST(RowRings, RowsBeginAtACacheLineAndHaveBordersOfZero) {
  for (const int width : {1, 16, 33}) {
    for (int round = 0; round < 2; ++round) {  // the second finds what the first has left
      RowRings rings(width, kBorder, 3 + 5);
      const PlaneRows<float> ring[2] = {rings.Add(3), rings.Add(5)};
      for (const PlaneRows<float>& r : ring) {
        for (int y = 0; y < r.period; ++y) {
          float* const row = r.Row(y);
          EXPECT_EQ(reinterpret_cast<uintptr_t>(row) % 64, 0u);
          EXPECT_EQ(std::count(row - kBorder, row, 0.0f), kBorder);
          EXPECT_EQ(std::count(row + width, row + width + kBorder, 0.0f), kBorder);
        }
      }
      for (const PlaneRows<float>& r : ring) {
        for (int y = 0; y < r.period; ++y) {
          // A vector from the last pixel's tap on; the sanitizer sees what lies outside.
          std::fill(r.Row(y) - kBorder, r.Row(y) + width + kBorder + 15, 1.0f);
        }
      }
    }
  }
}

}  // namespace
}  // namespace stillray
