// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "view/sample_rate.h"

#include <cmath>

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

/// A machine: a pixel's guides, a sample and a pixel's filter cost so much.
struct Machine {
  double guides_ms = 10;  // whole picture at scale 1
  double sample_ms = 200;
  double filter_ms = 60;

  FrameCost Cost(const RateControl& control) const {
    const double area = std::pow(control.scale(), 2.0);
    return {area * (guides_ms + sample_ms * control.rate().value()), area * filter_ms};
  }
};

void Observe(const Machine& machine, double target_ms, bool auto_scale, int frames,
             RateControl* control) {
  for (int i = 0; i < frames; ++i) {
    control->Observe(machine.Cost(*control), target_ms, auto_scale);
  }
}

TEST(RateControl, FindsTheMostSamplesThatFit) {
  RateControl control({1, 16}, 0.5f);
  const Machine machine;
  Observe(machine, 50, false, 60, &control);
  // At half the size: filter 15, guides 2.5; 1/2 sample costs 25, one 50.
  EXPECT_EQ(control.rate(), (SampleRate{1, 2}));
  EXPECT_FLOAT_EQ(control.scale(), 0.5f);
}

TEST(RateControl, SettlesAndStaysSettled) {
  for (const double target : {20.0, 33.0, 50.0, 100.0, 250.0}) {
    for (const double sample_ms : {20.0, 90.0, 400.0, 3000.0}) {
      Machine machine;
      machine.sample_ms = sample_ms;
      RateControl control;
      Observe(machine, target, true, 400, &control);
      const SampleRate rate = control.rate();
      const float scale = control.scale();
      for (int i = 0; i < 100; ++i) {
        Observe(machine, target, true, 1, &control);
        ASSERT_EQ(control.rate(), rate) << target << " " << sample_ms;
        ASSERT_EQ(control.scale(), scale) << target << " " << sample_ms;
      }
      EXPECT_LE(machine.Cost(control).total(), target * 1.1) << target << " " << sample_ms;
    }
  }
}

TEST(RateControl, FallsAtOnceWhenAFrameIsFarTooLate) {
  RateControl control({4, 1}, 1.0f);
  control.Observe({800, 20}, 50, false);
  EXPECT_LE(control.rate().value(), 4.0 * 50 / 800);
}

TEST(RateControl, OneLateFrameIsForgiven) {
  RateControl control({1, 4}, 0.5f);
  control.Observe({40, 20}, 50, true);
  EXPECT_EQ(control.rate(), (SampleRate{1, 4}));
  control.Observe({25, 20}, 50, true);
  EXPECT_EQ(control.rate(), (SampleRate{1, 4}));
}

TEST(RateControl, ASlowFilterCostsResolutionNotSamples) {
  RateControl control({1, 4}, 1.0f);
  control.Observe({5, 200}, 50, true);
  EXPECT_LT(control.scale(), 1.0f);
  EXPECT_EQ(control.rate(), (SampleRate{1, 4}));
}

TEST(RateControl, WithAFixedResolutionOnlySamplesChange) {
  RateControl control({1, 4}, 1.0f);
  const Machine machine{10, 2000, 30};
  Observe(machine, 50, false, 30, &control);
  EXPECT_FLOAT_EQ(control.scale(), 1.0f);
  EXPECT_LE(machine.Cost(control).total(), 55);
}

TEST(RateControl, SamplesStayWhereTheyCostLittle) {
  RateControl control({1, 4}, 0.25f);
  for (int i = 0; i < 30; ++i) {
    control.Observe({10, 200}, 50, true);
  }
  EXPECT_EQ(control.rate(), (SampleRate{1, 4}));
}

TEST(RateControl, AFallThatDoesNotHelpIsTakenBack) {
  RateControl control({1, 8}, 0.25f);
  for (int i = 0; i < 300; ++i) {
    control.Observe({100, 100}, 50, true);  // whatever is traced: the machine is busy elsewhere
  }
  EXPECT_GE(control.rate().value(), 1.0 / 64);
}

TEST(RateControl, AFastMachineGetsFullResolutionAndManySamples) {
  RateControl control;
  Machine machine{0.5, 3, 2};
  Observe(machine, 50, true, 500, &control);
  EXPECT_FLOAT_EQ(control.scale(), 1.0f);
  EXPECT_GE(control.rate().value(), 8);
}

}  // namespace
}  // namespace stillray::view
