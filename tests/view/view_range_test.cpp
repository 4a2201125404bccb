// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "view/view_range.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

namespace stillray::view::view_range_test {
namespace {

float TopOf(std::vector<float> values) {
  return FittedTop(&values);
}

TEST(ViewRange, TheTopIsAPowerOfTwoThatFits) {
  EXPECT_EQ(TopOf({0.1f, 0.2f, 3.0f}), 0.25f) << "one value in three is an outlier of so few";
  EXPECT_EQ(TopOf({3, 3, 3}), 4);
  EXPECT_EQ(TopOf({4, 4, 4}), 4);
  EXPECT_EQ(TopOf({0.003f, 0.003f}), 1.0f / 256);
}

TEST(ViewRange, OneValueInAHundredMayExceedIt) {
  std::vector<float> values(1000, 0.9f);
  values[17] = 1e6f;
  values[400] = INFINITY;
  values[600] = NAN;
  EXPECT_EQ(TopOf(values), 1);
}

TEST(ViewRange, NothingStillHasAScale) {
  EXPECT_GT(TopOf({}), 0);
  EXPECT_GT(TopOf({0, 0, 0}), 0);
  EXPECT_GT(TopOf({NAN, INFINITY}), 0);
}

TEST(ViewRange, PlacesOnTheScale) {
  const ViewRange linear = {8, false, false, ""};
  EXPECT_FLOAT_EQ(linear.At(0), 0);
  EXPECT_FLOAT_EQ(linear.At(2), 0.25f);
  const ViewRange logarithmic = {15, true, false, ""};
  EXPECT_FLOAT_EQ(logarithmic.At(0), 0);
  EXPECT_FLOAT_EQ(logarithmic.At(3), 0.5f);
  EXPECT_FLOAT_EQ(logarithmic.At(15), 1);
}

}  // namespace
}  // namespace stillray::view::view_range_test
