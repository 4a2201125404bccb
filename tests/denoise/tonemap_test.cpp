// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/stages/tonemap.h"

#include <cmath>
#include <cstdlib>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "stage_test.h"

namespace stillray::tonemap_test {
namespace {

using Version = decltype(&cpu::Tonemap);
constexpr Version kVersions[] = {&reference::Tonemap, &cpu::Tonemap};

constexpr int kLinear = 0;
constexpr int kCurves = 4;

std::vector<uint8_t> RunStage(Version tonemap, const Image3& colour, const TonemapParameters& p) {
  std::vector<uint8_t> bytes(3 * static_cast<size_t>(colour.width()) *
                             static_cast<size_t>(colour.height()));
  tonemap(colour, p, bytes.data());
  return bytes;
}

/// Grey pixels in a row.
Image3 Row(const std::vector<float>& values) {
  return test::MakeImage(static_cast<int>(values.size()), 1,
                         [&](int x, int, int) { return values[static_cast<size_t>(x)]; });
}

TEST(Tonemap, BytesAreSrgb) {
  const Image3 row = Row({0, 1, 0.5f, 0.002f, 0.25f, 2});
  for (const Version version : kVersions) {
    const std::vector<uint8_t> bytes = RunStage(version, row, {1, kLinear, 0, 0});
    // 255 * 0.735357 = 187.5; 255 * 12.92 * 0.002 = 6.6; 255 * 0.537099 = 137.0.
    const int expected[] = {0, 255, 188, 7, 137, 255};
    for (size_t i = 0; i < 6; ++i) {
      for (size_t c = 0; c < 3; ++c) {
        EXPECT_EQ(bytes[3 * i + c], expected[i]) << i;
      }
    }
  }
}

TEST(Tonemap, ChannelsKeepTheirOrderAndTheScaleIsExposure) {
  Image3 colour(1, 1);
  colour[0](0, 0) = 0.125f;
  colour[1](0, 0) = 0.0625f;
  colour[2](0, 0) = 0.25f;
  for (const Version version : kVersions) {
    const std::vector<uint8_t> bytes = RunStage(version, colour, {4, kLinear, 0, 0});
    EXPECT_EQ(bytes[0], 188);
    EXPECT_EQ(bytes[1], 137);
    EXPECT_EQ(bytes[2], 255);
  }
}

TEST(Tonemap, BrokenLightIsBlackOrWhite) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  const Image3 row = Row({std::numeric_limits<float>::quiet_NaN(), -kInfinity, -1, kInfinity});
  for (int curve = 0; curve < kCurves; ++curve) {
    for (const Version version : kVersions) {
      const std::vector<uint8_t> bytes = RunStage(version, row, {1, curve, 0, 0});
      EXPECT_EQ(bytes[0], 0) << curve;
      EXPECT_EQ(bytes[3], 0) << curve;
      EXPECT_EQ(bytes[6], 0) << curve;
      EXPECT_EQ(bytes[9], 255) << curve;
    }
  }
}

TEST(Tonemap, DitherKeepsTheMeanAndTheEnds) {
  constexpr int kWidth = 128;
  constexpr int kHeight = 128;
  Image3 grey(kWidth, kHeight);
  grey[0].Fill(0);
  grey[1].Fill(0.2f);
  grey[2].Fill(1);
  const double display = 255 * (1.055 * std::pow(0.2, 1 / 2.4) - 0.055);
  for (const Version version : kVersions) {
    const std::vector<uint8_t> bytes = RunStage(version, grey, {1, kLinear, 1, 5});
    const std::vector<uint8_t> next = RunStage(version, grey, {1, kLinear, 1, 6});
    double sum = 0;
    int different = 0;
    for (size_t i = 0; i < bytes.size(); i += 3) {
      EXPECT_EQ(bytes[i], 0);
      EXPECT_EQ(bytes[i + 2], 255);
      EXPECT_NEAR(bytes[i + 1], display, 1.6);
      sum += bytes[i + 1];
      different += bytes[i + 1] != next[i + 1] ? 1 : 0;
    }
    // Triangular noise and rounding have a deviation of about 0.5 together.
    EXPECT_NEAR(sum / (kWidth * kHeight), display, 4 * 0.5 / 128);
    EXPECT_GT(different, kWidth * kHeight / 4);
  }
}

TEST(Tonemap, VectorsMatchTheReferenceWithinAStep) {
  test::ForSizesAndTargets([](int width, int height) {
    const Image3 colour = test::MakeImage(width, height, [](int x, int y, int c) {
      return std::exp2(14 * test::RandomAt(x, y, static_cast<uint32_t>(c)) - 10);
    });
    for (int curve = 0; curve < kCurves; ++curve) {
      for (const float dither : {0.0f, 1.0f}) {
        const TonemapParameters p = {1.5f, curve, dither, 3};
        const std::vector<uint8_t> expected = RunStage(&reference::Tonemap, colour, p);
        const std::vector<uint8_t> got = RunStage(&cpu::Tonemap, colour, p);
        int different = 0;
        for (size_t i = 0; i < expected.size(); ++i) {
          const int difference = std::abs(got[i] - expected[i]);
          ASSERT_LE(difference, 1) << i;
          different += difference;
        }
        // Values that lie on the boundary of two steps.
        EXPECT_LE(different, 1 + static_cast<int>(expected.size()) / 200);
      }
    }
  });
}

}  // namespace
}  // namespace stillray::tonemap_test
