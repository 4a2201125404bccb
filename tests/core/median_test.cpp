// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "core/median.h"

#include <gtest/gtest.h>

namespace stillray::median_test {
namespace {

TEST(Median, IsTheMiddleOfAnyOrderAndTheUpperOfTwo) {
  EXPECT_EQ(Median(std::vector<double>{}), 0.0);
  EXPECT_EQ(Median(std::vector<float>{3.0f}), 3.0f);
  EXPECT_EQ(Median(std::vector<double>{9.0, 1.0, 4.0}), 4.0);
  EXPECT_EQ(Median(std::vector<double>{8.0, 2.0, 1.0, 4.0}), 4.0);
}

}  // namespace
}  // namespace stillray::median_test
