// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "view/sample_rate.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace stillray::view {
namespace {

using ::testing::HasSubstr;

TEST(SampleRate, ReadsWholeNumbersAndFractions) {
  EXPECT_EQ(ParseSampleRate("4").value(), (SampleRate{4, 1}));
  EXPECT_EQ(ParseSampleRate("1/8").value(), (SampleRate{1, 8}));
  EXPECT_EQ(ParseSampleRate("0.125").value(), (SampleRate{1, 8}));
  EXPECT_EQ(ParseSampleRate("1/1").value(), (SampleRate{1, 1}));
}

TEST(SampleRate, NamesWhatItCannotRead) {
  for (const char* text : {"", "0", "-1", "2/3", "1/0", "1/257", "0.3", "1/", "/2", "x", "1e9",
                           "nan", "0.000001", "65537", "1/8x"}) {
    const Result<SampleRate> rate = ParseSampleRate(text);
    ASSERT_FALSE(rate.ok()) << text;
    EXPECT_THAT(rate.status().message(), HasSubstr(std::string("'") + text + "'"));
  }
}

TEST(SampleRate, TextReadsBack) {
  for (const SampleRate rate : {SampleRate{1, 1}, SampleRate{64, 1}, SampleRate{1, 256}}) {
    EXPECT_EQ(ParseSampleRate(ToText(rate)).value(), rate);
  }
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
}  // namespace stillray::view
