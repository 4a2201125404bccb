// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/stages/sum_albedo.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "stage_test.h"

namespace stillray::sum_albedo_test {
namespace {

TEST(SumAlbedo, VectorVersionIsTheReference) {
  test::ForSizesAndTargets([](int width, int height) {
    Image3 first = test::RandomImage(width, height, 1);
    first[0](width / 2, height / 2) = std::nanf("");
    first[1](width - 1, 0) = HUGE_VALF;
    first[2](0, height - 1) = -0.5f;
    const Image3 second = test::RandomImage(width, height, 2);
    const Image3* const albedos[2] = {&first, &second};
    SummedAlbedo expected(width, height);
    reference::SumAlbedo(albedos, &expected);
    SummedAlbedo found(width, height);
    for (int repeat = 0; repeat < 2; ++repeat) {  // nothing is left of an earlier frame
      cpu::SumAlbedo(albedos, &found);
      for (int c = 0; c < 3; ++c) {
        test::ExpectEqual(found.sum[c], expected.sum[c]);
        test::ExpectEqual(found.low[c], expected.low[c]);
        test::ExpectEqual(found.high[c], expected.high[c]);
      }
    }
  });
}

TEST(SumAlbedo, WhatIsNoAlbedoCountsAsZero) {
  Image3 first(8, 4);
  Image3 second(8, 4);
  first[0].Fill(0.5f);
  second[0].Fill(0.25f);
  first[0](0, 0) = std::nanf("");
  first[0](1, 0) = -HUGE_VALF;
  first[0](2, 0) = -3;
  second[0](3, 0) = std::numeric_limits<float>::infinity();
  const Image3* const albedos[2] = {&first, &second};
  SummedAlbedo out(8, 4);
  cpu::SumAlbedo(albedos, &out);
  const float expected[] = {0.25f, 0.25f, 0.25f, 0.5f, 0.75f, 0.75f};
  for (int x = 0; x < 6; ++x) {
    EXPECT_EQ(out.sum[0](x, 0), expected[x]) << x;
  }
}

// A single bright pixel widens the range of its block and of those next to it.
TEST(SumAlbedo, TheRangeIsThatOfTheBlocksAround) {
  Image3 albedo(40, 30);
  for (int c = 0; c < 3; ++c) {
    albedo[c].Fill(0.5f);
  }
  albedo[1](17, 14) = 0.9f;  // block (4, 3)
  albedo[1](0, 0) = 0.1f;
  const Image3* const albedos[1] = {&albedo};
  SummedAlbedo out(40, 30);
  cpu::SumAlbedo(albedos, &out);
  for (int y = 0; y < AlbedoBlocks(30); ++y) {
    for (int x = 0; x < AlbedoBlocks(40); ++x) {
      const bool near_bright = std::abs(x - 4) <= 1 && std::abs(y - 3) <= 1;
      EXPECT_EQ(out.high[1](x, y), near_bright ? 0.9f : 0.5f) << x << " " << y;
      EXPECT_EQ(out.low[1](x, y), x <= 1 && y <= 1 ? 0.1f : 0.5f) << x << " " << y;
      EXPECT_EQ(out.high[0](x, y), 0.5f);
    }
  }
}

}  // namespace
}  // namespace stillray::sum_albedo_test
