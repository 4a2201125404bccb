// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/stages/clip_outliers.h"

#include <algorithm>
#include <cstddef>

#include <gtest/gtest.h>

#include "denoise/stages/clip_outliers_shared.h"
#include "stage_test.h"

namespace stillray::clip_outliers_test {
namespace {

using test::MakeImage;
using test::MakePlane;
using test::RandomAt;

using Clip = decltype(&cpu::ClipOutliers);
constexpr Clip kClips[] = {&reference::ClipOutliers, &cpu::ClipOutliers};
constexpr int kWidth = 19;
constexpr int kHeight = 5;
constexpr ClipOutliersParameters kParameters = {.clip_outliers = 4};

TEST(ClipOutliers, Formulas) {
  EXPECT_FALSE(IsOutlier(2, 1, 3, 100, 4));  // in the range
  EXPECT_FALSE(IsOutlier(3, 1, 3, 100, 4));
  EXPECT_FALSE(IsOutlier(3.15f, 1, 3, 100, 4));  // by less than 5 %
  EXPECT_TRUE(IsOutlier(3.17f, 1, 3, 100, 4));
  EXPECT_TRUE(IsOutlier(5, 1, 3, 0.25f, 4));  // 4 deviations of 0.5
  EXPECT_FALSE(IsOutlier(5.01f, 1, 3, 0.25f, 4));
  EXPECT_TRUE(IsOutlier(0, 1, 3, 0.25f, 4));
  EXPECT_FALSE(IsOutlier(0, 1, 3, 0, 4));  // no noise
  EXPECT_FLOAT_EQ(ClippedScale(5, 1, 3, 2), 1.5f);
  EXPECT_FLOAT_EQ(ClippedScale(0.5f, 1, 3, 2), 0.5f);
  EXPECT_EQ(ClippedScale(5, 0, 0, 0), 1);
}

struct Planes {
  LumaImage3 light = LumaImage3(kWidth, kHeight, 1);
  Image1 variance = Image1(kWidth, kHeight, 1);
  Image1 where = Image1(kWidth, kHeight, 1);

  /// A ramp of luminance 10, 11, ... of red 0.5 and blue 2 times that.
  Planes() {
    variance.Fill(100);
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        Set(x, y, 10.0f + static_cast<float>(x), 0.5f, 2);
        where(x, y) = 1;
      }
    }
  }
  void Set(int x, int y, float luminance, float red, float blue) {
    light[0](x, y) = luminance;
    light[1](x, y) = luminance * red;
    light[2](x, y) = luminance * blue;
  }
  LumaImage3 Clipped(Clip clip) const {
    LumaImage3 result = light;
    FilterPlanes scratch(kWidth, kHeight, 1);
    clip({&variance, &where}, kParameters, &scratch, &result);
    return result;
  }
};

TEST(ClipOutliers, SpecksTakeTheLightOfTheirNeighbours) {
  Planes planes;
  planes.Set(9, 2, 50, 0.1f, 0.1f);  // its neighbours have 18, 19, 20
  planes.Set(3, 2, 0, 0, 0);         // and this one's 12, 13, 14
  for (const Clip clip : kClips) {
    const LumaImage3 out = planes.Clipped(clip);
    EXPECT_NEAR(out[0](9, 2), 20, 1e-4f);
    EXPECT_NEAR(out[1](9, 2), 10, 1e-4f);
    EXPECT_NEAR(out[2](9, 2), 40, 1e-4f);
    EXPECT_NEAR(out[0](3, 2), 12, 1e-4f);
    EXPECT_NEAR(out[1](3, 2), 6, 1e-4f);
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        const bool speck = y == 2 && (x == 9 || x == 3);
        // A ramp is in the range of its neighbours everywhere.
        ASSERT_TRUE(speck || out[0](x, y) == planes.light[0](x, y)) << x << " " << y;
      }
    }
  }
}

TEST(ClipOutliers, WhatNoiseDoesNotExplainStays) {
  Planes planes;
  planes.Set(9, 2, 50, 0.1f, 0.1f);
  planes.variance(9, 2) = 56.0f;  // four deviations are 29.93, the excess is 30
  for (const Clip clip : kClips) {
    EXPECT_EQ(planes.Clipped(clip)[0](9, 2), 50);
    planes.variance(9, 2) = 56.3f;
    EXPECT_NEAR(planes.Clipped(clip)[0](9, 2), 20, 1e-4f);
    planes.variance(9, 2) = 56.0f;
  }
}

TEST(ClipOutliers, OnlyPixelsWithLightCount) {
  Planes planes;
  planes.where.Fill(0);
  planes.where(9, 2) = 1;
  planes.Set(9, 2, 50, 1, 1);
  planes.Set(10, 2, 1e9f, 1, 1);
  for (const Clip clip : kClips) {
    EXPECT_EQ(planes.Clipped(clip)[0](9, 2), 50);  // alone
    planes.where(8, 1) = 1;
    const LumaImage3 out = planes.Clipped(clip);
    EXPECT_NEAR(out[0](9, 2), 18, 1e-4f);
    EXPECT_EQ(out[0](10, 2), 1e9f);  // not light
    planes.where(8, 1) = 0;
  }
}

TEST(ClipOutliers, BlocksWithLightEverywhereGiveTheSame) {
  test::ForSizesAndTargets([](int width, int height) {
    const auto light = MakeImage<LumaImage3>(
        width, height, [](int x, int y, int c) { return RandomAt(x, y, static_cast<uint32_t>(c)); },
        1);
    Image1 variance(width, height, 1);
    variance.Fill(1);
    const Image1 where = MakePlane(
        width, height, [](int, int) { return 1.0f; }, 1);
    // Blocks at the border of the picture are not full.
    Plane<uint32_t> full(BlocksOf(width), height, 1);
    for (int y = 0; y < height; ++y) {
      for (int i = 0; i < BlocksOf(width); ++i) {
        full(i, y) = (i + 1) * kBlockPixels <= width ? ~0u : 0u;
      }
    }
    LumaImage3 expected = light;
    LumaImage3 got = light;
    FilterPlanes scratch(width, height, 1);
    reference::ClipOutliers({&variance, &where}, kParameters, &scratch, &expected);
    cpu::ClipOutliers({&variance, &where, &full}, kParameters, &scratch, &got);
    test::ExpectNear(got, expected, 1e-5);
  });
}

TEST(ClipOutliers, VersionsAgree) {
  test::ForSizesAndTargets([](int width, int height) {
    const auto light = MakeImage<LumaImage3>(
        width, height,
        [](int x, int y, int c) {
          const float speck = RandomAt(x, y, 7) < 0.1f ? 10.0f : 1.0f;
          return speck * (1 + RandomAt(x, y, static_cast<uint32_t>(c)));
        },
        1);
    const Image1 variance = MakePlane(
        width, height, [](int x, int y) { return 4 * RandomAt(x, y, 4); }, 1);
    const Image1 where = MakePlane(
        width, height, [](int x, int y) { return RandomAt(x, y, 5) < 0.8f ? 1.0f : 0.0f; }, 1);
    LumaImage3 expected = light;
    LumaImage3 got = light;
    FilterPlanes scratch(width, height, 1);
    reference::ClipOutliers({&variance, &where}, kParameters, &scratch, &expected);
    // The denoiser may give the same plane for both.
    scratch.variance = variance;
    cpu::ClipOutliers({&scratch.variance, &where}, kParameters, &scratch, &got);
    test::ExpectNear(got, expected, 1e-5);
  });
}

}  // namespace
}  // namespace stillray::clip_outliers_test
