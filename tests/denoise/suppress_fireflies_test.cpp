// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/stages/suppress_fireflies.h"

#include <gtest/gtest.h>

#include "denoise/stages/suppress_fireflies_shared.h"
#include "stage_test.h"

namespace stillray::suppress_fireflies_test {
namespace {

using Clamp = decltype(&cpu::ClampFireflies);
constexpr Clamp kClamps[] = {&reference::ClampFireflies, &cpu::ClampFireflies};
using Curve = decltype(&cpu::CompressLight);

/// Grey of luminance 1, but for one pixel.
LumaImage3 WithFirefly(float l, float r, float b) {
  const float value[3] = {l, r, b};
  return test::MakeImage<LumaImage3>(
      19, 5, [&](int x, int y, int c) { return x == 9 && y == 2 ? value[c] : 1.0f; });
}

TEST(ClampFireflies, ScalesToTheBrightestNeighbour) {
  LumaImage3 light = WithFirefly(100, 50, 20);
  light[0](10, 3) = 4;  // the brightest of the eight
  Image1 samples(19, 5);
  samples.Fill(1);
  for (const Clamp clamp : kClamps) {
    Image1 work;
    LumaImage3 out(19, 5);
    clamp(light, samples, &work, &out);
    EXPECT_NEAR(out[0](9, 2), 4, 1e-5f);
    EXPECT_NEAR(out[1](9, 2), 2, 1e-5f);  // the hue stays
    EXPECT_NEAR(out[2](9, 2), 0.8f, 1e-5f);
    EXPECT_EQ(out[0](10, 3), 4);  // its neighbour is brighter
    EXPECT_EQ(out[0](0, 0), 1);
    EXPECT_EQ(out[0](18, 4), 1);
  }
}

TEST(ClampFireflies, NeighboursWithoutSamplesDoNotCount) {
  const LumaImage3 light = WithFirefly(100, 100, 100);
  Image1 samples(19, 5);
  samples(9, 2) = 1;
  for (const Clamp clamp : kClamps) {
    Image1 work;
    LumaImage3 out(19, 5);
    clamp(light, samples, &work, &out);
    EXPECT_EQ(out[0](9, 2), 100);  // alone: nothing to compare with
    samples(8, 1) = 1;
    clamp(light, samples, &work, &out);
    EXPECT_NEAR(out[0](9, 2), 1, 1e-6f);
    samples(8, 1) = 0;
  }
}

TEST(CompressLight, BendsAboveTheKneeOnly) {
  const LumaImage3 light = test::MakeImage<LumaImage3>(9, 1, [](int x, int, int c) {
    return (x == 0 ? kKnee : 2 * kKnee * static_cast<float>(x)) / static_cast<float>(1 + c);
  });
  for (const Curve compress : {&reference::CompressLight, &cpu::CompressLight}) {
    LumaImage3 out = light;
    compress(&out);
    EXPECT_EQ(out[0](0, 0), kKnee);
    // Luminance 64: 1/2 * (2 - 1/2) of it.
    EXPECT_NEAR(out[0](1, 0), 48, 1e-4f);
    EXPECT_NEAR(out[1](1, 0), 24, 1e-4f);
    for (int x = 1; x < 9; ++x) {
      EXPECT_GT(out[0](x, 0), out[0](x - 1, 0));
      EXPECT_LT(out[0](x, 0), 2 * kKnee);
    }
  }
}

TEST(CompressLight, ExpandIsItsInverse) {
  const LumaImage3 light = test::MakeImage<LumaImage3>(33, 1, [](int x, int, int c) {
    return std::exp2(0.25f * static_cast<float>(x)) / static_cast<float>(1 + c);
  });
  for (const auto& [compress, expand] :
       {std::pair{&reference::CompressLight, &reference::ExpandLight},
        std::pair{&cpu::CompressLight, &cpu::ExpandLight}}) {
    LumaImage3 out = light;
    compress(&out);
    expand(&out);
    test::ExpectNear(out, light, 1e-4);
  }
}

TEST(SuppressFireflies, VectorsMatchTheReference) {
  test::ForSizesAndTargets([](int width, int height) {
    const LumaImage3 light = test::MakeImage<LumaImage3>(width, height, [](int x, int y, int c) {
      return std::exp2(12 * test::RandomAt(x, y, 1) - 2) / static_cast<float>(1 + c);
    });
    const Image1 samples = test::MakePlane(
        width, height, [](int x, int y) { return test::RandomAt(x, y, 2) < 0.6f ? 1.0f : 0.0f; });
    Image1 work;
    LumaImage3 expected(width, height);
    LumaImage3 got(width, height);
    reference::ClampFireflies(light, samples, &work, &expected);
    cpu::ClampFireflies(light, samples, &work, &got);
    test::ExpectNear(got, expected, 1e-6);
    expected = got = light;
    reference::CompressLight(&expected);
    cpu::CompressLight(&got);
    test::ExpectNear(got, expected, 1e-6);
    reference::ExpandLight(&expected);
    cpu::ExpandLight(&got);
    test::ExpectNear(got, expected, 1e-5);
  });
}

}  // namespace
}  // namespace stillray::suppress_fireflies_test
