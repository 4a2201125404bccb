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
    reference::SumAlbedo(albedos, nullptr, &expected);
    SummedAlbedo found(width, height);
    for (int repeat = 0; repeat < 2; ++repeat) {  // nothing is left of an earlier frame
      cpu::SumAlbedo(albedos, nullptr, &found);
      for (int c = 0; c < 3; ++c) {
        test::ExpectEqual(found.sum[c], expected.sum[c]);
        test::ExpectEqual(found.low[c], expected.low[c]);
        test::ExpectEqual(found.high[c], expected.high[c]);
      }
    }
  });
}

/// Random images: none, near, far, and alike within the tolerance.
Image1 RandomImages(int width, int height) {
  const Image3 random = test::RandomImage(width, height, 7);
  Image1 images(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const float kind = random[0](x / 16, y / 16);
      images(x, y) = kind < 0.3f ? 0.0f : (kind < 0.6f ? 5.0f : 9.0f);
      images(x, y) *= 1 + 0.04f * random[1](x, y);
    }
  }
  return images;
}

TEST(SumAlbedo, VectorVersionMarksTheSameImages) {
  test::ForSizesAndTargets([](int width, int height) {
    const Image3 albedo = test::RandomImage(width, height, 1);
    const Image3* const albedos[1] = {&albedo};
    const Image1 images = RandomImages(width, height);
    SummedAlbedo expected(width, height);
    reference::SumAlbedo(albedos, &images, &expected);
    SummedAlbedo found(width, height);
    for (int repeat = 0; repeat < 2; ++repeat) {
      cpu::SumAlbedo(albedos, &images, &found);
      test::ExpectEqual(found.beside_image, expected.beside_image);
      cpu::SumAlbedo(albedos, nullptr, &found);
      EXPECT_TRUE(found.beside_image.empty());
    }
  });
}

TEST(SumAlbedo, ImagesBesideOthersAreMarked) {
  Image3 albedo(64, 24);
  const Image3* const albedos[1] = {&albedo};
  Image1 images(64, 24);
  for (int y = 0; y < 24; ++y) {
    for (int x = 0; x < 64; ++x) {
      images(x, y) = x < 16 ? 0.0f : (x < 40 ? 10.0f : 10.4f);  // none, and two of one surface
    }
  }
  images(56, 9) = 12;  // block (14, 2)
  SummedAlbedo out(64, 24);
  cpu::SumAlbedo(albedos, &images, &out);
  for (int y = 0; y < 24; ++y) {
    for (int x = 0; x < 64; ++x) {
      const bool near_edge = x >= 16 && x < 20;
      const bool near_other = std::abs(x / 4 - 14) <= 1 && std::abs(y / 4 - 2) <= 1;
      EXPECT_EQ(out.beside_image(x, y), near_edge || near_other ? 1 : 0) << x << " " << y;
    }
  }
}

// Devices hold logarithms.
TEST(SumAlbedo, BesideImagesByDepthAndByItsLogarithm) {
  for (const float depth : {1e-3f, 1.0f, 3.7f, 1e6f}) {
    for (const float farther : {1.0f, 1.03f, 1.049f, 1.051f, 1.2f, 40.0f}) {
      EXPECT_EQ(IsBesideImage(depth, depth, farther * depth), farther > 1.05f);
      EXPECT_EQ(IsBesideImageByLog(std::log2(depth), std::log2(depth), std::log2(farther * depth)),
                farther > 1.05f);
    }
    EXPECT_TRUE(IsBesideImage(depth, 0, depth));
    EXPECT_TRUE(IsBesideImageByLog(std::log2(depth), kNoImage, std::log2(depth)));
    EXPECT_FALSE(IsBesideImage(0, 0, depth));
    EXPECT_FALSE(IsBesideImageByLog(kNoImage, kNoImage, std::log2(depth)));
  }
  EXPECT_FALSE(IsBesideImageByLog(kFarthestImage, kFarthestImage, kFarthestImage));
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
  cpu::SumAlbedo(albedos, nullptr, &out);
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
  cpu::SumAlbedo(albedos, nullptr, &out);
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
