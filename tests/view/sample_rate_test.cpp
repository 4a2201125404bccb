// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "view/sample_rate.h"

#include <gtest/gtest.h>

namespace stillray::view::sample_rate_test {
namespace {

TEST(SampleRate, TextIsThatOfTheSetting) {
  EXPECT_EQ(ToText({1, 1}), "1");
  EXPECT_EQ(ToText({64, 1}), "64");
  EXPECT_EQ(ToText({1, 256}), "1/256");
}

TEST(SampleRate, DoublingAndHalvingWalkPowersOfTwo) {
  SampleRate rate{1, 256};
  for (int steps = 0; steps < 14; ++steps) {
    EXPECT_EQ(Halved(Doubled(rate)), rate);
    EXPECT_DOUBLE_EQ(Doubled(rate).value(), 2 * rate.value());
    rate = Doubled(rate);
  }
  EXPECT_EQ(rate, (SampleRate{kMaxLiveSpp, 1}));
  EXPECT_EQ(Doubled(rate), rate);
  EXPECT_EQ(Halved({1, 256}), (SampleRate{1, 256}));
}

TEST(SampleRate, OddRatesFindTheirWayBackToPowersOfTwo) {
  EXPECT_EQ(Halved({3, 1}), (SampleRate{2, 1}));
  EXPECT_EQ(Doubled({3, 1}), (SampleRate{4, 1}));
  EXPECT_EQ(Doubled({1, 3}), (SampleRate{1, 2}));
  EXPECT_EQ(Halved({1, 3}), (SampleRate{1, 4}));
  EXPECT_EQ(Doubled({100, 1}), (SampleRate{100, 1}));
}

}  // namespace
}  // namespace stillray::view::sample_rate_test
