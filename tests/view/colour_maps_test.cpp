// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "view/colour_maps.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace stillray::view::colour_maps_test {
namespace {

constexpr Rgb8 kMagenta = {255, 0, 255};
constexpr Rgb8 kCyan = {0, 255, 255};

float Luma(Rgb8 c) {
  return 0.2126f * c.r + 0.7152f * c.g + 0.0722f * c.b;
}

TEST(ColourMaps, HeatGrowsBrighterThroughout) {
  float last = -1;
  for (int i = 0; i <= 100; ++i) {
    const float luma = Luma(Heat(static_cast<float>(i) / 100));
    EXPECT_GE(luma, last) << i;
    last = luma;
  }
  EXPECT_LT(Luma(Heat(0)), 3);
  EXPECT_GT(Luma(Heat(1)), 245);
  EXPECT_EQ(Heat(-1), Heat(0));
  EXPECT_EQ(Heat(7), Heat(1));
}

TEST(ColourMaps, NanIsMagentaAndInfinityCyan) {
  EXPECT_EQ(Grey(NAN), kMagenta);
  EXPECT_EQ(Grey(INFINITY), kCyan);
  EXPECT_EQ(Heat(NAN), kMagenta);
  EXPECT_EQ(Heat(INFINITY), kCyan);
  EXPECT_EQ(Heat(-INFINITY), kCyan);
  EXPECT_EQ(NormalColour(NAN, 0, 1), kMagenta);
  EXPECT_EQ(NormalColour(0, -INFINITY, INFINITY), kCyan);
  EXPECT_EQ(MotionColour(INFINITY, 0, 1), kCyan);
  EXPECT_EQ(MotionColour(INFINITY, NAN, 1), kMagenta) << "NaN goes before infinity";
  EXPECT_FALSE(NotFiniteColour(3e38f, 3e38f, -3e38f)) << "their sum overflows, they do not";
}

TEST(ColourMaps, NormalsAndTheirAbsence) {
  EXPECT_EQ(NormalColour(0, 0, 1), (Rgb8{128, 128, 255}));
  EXPECT_EQ(NormalColour(-1, 0, 0), (Rgb8{0, 128, 128}));
  EXPECT_EQ(NormalColour(0, 0, 0), (Rgb8{0, 0, 0}));
}

TEST(ColourMaps, MotionShowsDirectionAndLength) {
  EXPECT_EQ(MotionColour(0, 0, 8), (Rgb8{0, 0, 0}));
  const Rgb8 right = MotionColour(4, 0, 8);
  EXPECT_EQ(right, (Rgb8{128, 0, 0}));
  EXPECT_EQ(MotionColour(0.004f, 0, 0.008f), right) << "slow motion on its own scale";
  const Rgb8 left = MotionColour(-4, 0, 8);
  EXPECT_EQ(left.r, 0);
  EXPECT_NEAR(left.g, left.b, 1);
  EXPECT_GT(Luma(MotionColour(40, 0, 8)), Luma(right));
}

TEST(ColourMaps, NeighbouringIdsDiffer) {
  EXPECT_EQ(IdColour(0), (Rgb8{0, 0, 0}));
  for (uint32_t id = 1; id < 200; ++id) {
    const Rgb8 a = IdColour(id);
    const Rgb8 b = IdColour(id + 1);
    EXPECT_GT(std::abs(a.r - b.r) + std::abs(a.g - b.g) + std::abs(a.b - b.b), 60) << id;
    EXPECT_GT(Luma(a), 8) << id;
  }
}

TEST(ColourMaps, SrgbEncodesKnownValues) {
  EXPECT_NEAR(ToSrgb(0.5f), 0.7354f, 1e-4f);
  EXPECT_NEAR(ToSrgb(0.002f), 0.02584f, 1e-5f);
  EXPECT_EQ(ToSrgb(-1), 0);
  EXPECT_NEAR(ToSrgb(9), 1, 1e-6f);
}

}  // namespace
}  // namespace stillray::view::colour_maps_test
