// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "core/half.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

namespace stillray::half_test {
namespace {

/// The value of a half by its definition.
double Exact(uint32_t half) {
  const double sign = (half & 0x8000u) != 0 ? -1.0 : 1.0;
  const int exponent = static_cast<int>(half >> 10 & 31u);
  const double mantissa = half & 0x3FFu;
  return sign *
         (exponent == 0 ? std::ldexp(mantissa, -24) : std::ldexp(1024.0 + mantissa, exponent - 25));
}

TEST(HalfTest, EveryHalfIsExactAndComesBack) {
  for (uint32_t h = 0; h < 0x10000u; ++h) {
    const float f = FloatFromHalf(static_cast<uint16_t>(h));
    if ((h >> 10 & 31u) == 31u) {
      EXPECT_EQ(std::isnan(f), (h & 0x3FFu) != 0) << h;
      EXPECT_EQ(std::isinf(f), (h & 0x3FFu) == 0) << h;
      EXPECT_EQ(std::signbit(f), (h & 0x8000u) != 0) << h;
    } else {
      EXPECT_EQ(static_cast<double>(f), Exact(h)) << h;
    }
    if (!std::isnan(f)) {
      EXPECT_EQ(HalfFromFloat(f), h);
    }
  }
}

TEST(HalfTest, RoundsToNearestTiesToEven) {
  for (uint32_t h = 0; h < 0x7BFFu; ++h) {
    const double low = Exact(h);
    const double high = Exact(h + 1);
    const auto middle = static_cast<float>((low + high) / 2);  // 12 bits: exact
    EXPECT_EQ(HalfFromFloat(middle), h % 2 == 0 ? h : h + 1) << h;
    EXPECT_EQ(HalfFromFloat(std::nextafter(middle, 0.0f)), h) << h;
    EXPECT_EQ(HalfFromFloat(std::nextafter(middle, 1e9f)), h + 1) << h;
    EXPECT_EQ(HalfFromFloat(-middle), 0x8000u | (h % 2 == 0 ? h : h + 1)) << h;
  }
}

TEST(HalfTest, TooLargeAndNotFinite) {
  EXPECT_EQ(HalfFromFloat(65519.996f), 0x7BFFu);
  EXPECT_EQ(HalfFromFloat(65520.0f), 0x7C00u);
  EXPECT_EQ(HalfFromFloat(3e38f), 0x7C00u);
  EXPECT_EQ(HalfFromFloat(-std::numeric_limits<float>::infinity()), 0xFC00u);
  EXPECT_TRUE(std::isnan(FloatFromHalf(HalfFromFloat(std::numeric_limits<float>::quiet_NaN()))));
  EXPECT_EQ(HalfFromFloat(1e-30f), 0u);
  EXPECT_EQ(HalfFromFloat(-1e-30f), 0x8000u);
}

}  // namespace
}  // namespace stillray::half_test
