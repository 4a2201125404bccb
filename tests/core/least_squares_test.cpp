// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "core/least_squares.h"

#include <array>

#include <gtest/gtest.h>

namespace stillray::least_squares_test {
namespace {

TEST(NormalEquations, SolvesWhatItsRowsDetermine) {
  const std::array<double, 3> known = {2.0, -1.0, 0.5};
  NormalEquations<3> equations;
  NormalEquations<3> part;
  for (int i = 0; i < 10; ++i) {
    const std::array<double, 3> row = {1.0, 0.3 * i, 0.1 * i * i};
    const double value = known[0] * row[0] + known[1] * row[1] + known[2] * row[2];
    (i % 2 == 0 ? equations : part).Add(row, value, 1 + i);
  }
  equations.Add(part);
  const std::array<double, 3> found = equations.Solve(0);
  for (size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(found[i], known[i], 1e-9);
  }
}

TEST(NormalEquations, WeightsCount) {
  NormalEquations<1> equations;
  equations.Add({1.0}, 0.0, 3.0);
  equations.Add({1.0}, 4.0, 1.0);
  EXPECT_NEAR(equations.Solve(0)[0], 1.0, 1e-12);
}

TEST(NormalEquations, WhatNoRowDeterminesIsZero) {
  NormalEquations<2> equations;
  equations.Add({1.0, 0.0}, 5.0, 1.0);
  const std::array<double, 2> found = equations.Solve(1e-12);
  EXPECT_NEAR(found[0], 5.0, 1e-9);
  EXPECT_EQ(found[1], 0.0);
}

}  // namespace
}  // namespace stillray::least_squares_test
