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
  double noise = 0;  // part of the time by which frames differ
  int burst = 0;     // every so many frames ...
  int busy = 0;      // ... this many take twice as long: something else runs
  int frame = 0;
  uint32_t state = 1;

  double Noise() {
    state = state * 1664525u + 1013904223u;
    return 1 + noise * (static_cast<double>(state >> 8) / (1 << 24) * 2 - 1);
  }
  FrameCost Cost(const RateControl& control) {
    const double area = std::pow(control.scale(), 2.0);
    const bool slow = burst > 0 && frame++ % burst < busy;
    const double factor = Noise() * (slow ? 2 : 1);
    const double fixed = area * guides_ms * factor;
    return {fixed + area * sample_ms * control.rate().value() * factor, area * filter_ms * factor,
            fixed};
  }
};

void Observe(Machine* machine, double target_ms, int frames, RateControl* control) {
  for (int i = 0; i < frames; ++i) {
    control->Observe(machine->Cost(*control), target_ms);
  }
}

RateControl Fixed(const SampleRate& rate, float scale) {
  RateControl control(rate, scale);
  control.ChooseScale(scale, false);
  return control;
}

TEST(RateControl, FindsTheMostSamplesThatFit) {
  RateControl control = Fixed({1, 16}, 0.5f);
  Machine machine;
  Observe(&machine, 50, 60, &control);
  // At half the size: filter 15, guides 2.5; 1/2 sample costs 25, one 50.
  EXPECT_EQ(control.rate(), (SampleRate{1, 2}));
  EXPECT_FLOAT_EQ(control.scale(), 0.5f);
}

/// How often rate and resolution change within so many frames.
struct Changes {
  int rate = 0;
  int scale = 0;
};

Changes CountChanges(Machine* machine, double target_ms, int frames, RateControl* control) {
  Changes changes;
  for (int i = 0; i < frames; ++i) {
    const SampleRate rate = control->rate();
    const float scale = control->scale();
    Observe(machine, target_ms, 1, control);
    changes.rate += rate == control->rate() ? 0 : 1;
    changes.scale += scale == control->scale() ? 0 : 1;
  }
  return changes;
}

TEST(RateControl, SettlesAndStaysSettled) {
  for (const double target : {20.0, 33.0, 50.0, 100.0, 250.0}) {
    for (const double sample_ms : {20.0, 90.0, 400.0, 3000.0}) {
      Machine machine;
      machine.sample_ms = sample_ms;
      RateControl control;
      Observe(&machine, target, 400, &control);
      const Changes changes = CountChanges(&machine, target, 200, &control);
      EXPECT_EQ(changes.rate, 0) << target << " " << sample_ms;
      EXPECT_EQ(changes.scale, 0) << target << " " << sample_ms;
      EXPECT_LE(machine.Cost(control).total(), target * 1.1) << target << " " << sample_ms;
    }
  }
}

TEST(RateControl, NoiseDoesNotMakeItSwing) {
  for (const double target : {20.0, 33.0, 50.0, 100.0}) {
    for (const double sample_ms : {20.0, 90.0, 400.0, 3000.0}) {
      Machine machine;
      machine.sample_ms = sample_ms;
      machine.noise = 0.25;
      RateControl control;
      Observe(&machine, target, 600, &control);
      // 1000 frames are 50 seconds at 20 frames per second.
      const Changes changes = CountChanges(&machine, target, 1000, &control);
      EXPECT_LE(changes.rate, 12) << target << " " << sample_ms;
      EXPECT_LE(changes.scale, 4) << target << " " << sample_ms;
    }
  }
}

TEST(RateControl, BurstsOfOtherWorkDoNotMakeItSwing) {
  Machine machine;
  machine.noise = 0.15;
  machine.burst = 60;
  machine.busy = 12;
  RateControl control;
  Observe(&machine, 50, 600, &control);
  const Changes changes = CountChanges(&machine, 50, 1000, &control);
  EXPECT_LE(changes.scale, 6);
  EXPECT_LE(changes.rate, 60);  // samples may well follow: nobody sees them jump
}

TEST(RateControl, FallsAtOnceWhenAFrameIsFarTooLate) {
  RateControl control = Fixed({4, 1}, 1.0f);
  control.Observe({800, 20}, 50);
  EXPECT_LE(control.rate().value(), 4.0 * 50 / 800);
}

TEST(RateControl, OneLateFrameIsForgiven) {
  RateControl control({1, 4}, 0.5f);
  control.Observe({40, 20}, 50);
  EXPECT_EQ(control.rate(), (SampleRate{1, 4}));
  control.Observe({25, 20}, 50);
  EXPECT_EQ(control.rate(), (SampleRate{1, 4}));
}

TEST(RateControl, TheChosenResolutionStaysWhileFewerSamplesHelp) {
  RateControl control({1, 2}, 0.8f);
  Machine machine{2, 3000, 20};
  for (int i = 0; i < 200; ++i) {
    Observe(&machine, 50, 1, &control);
    ASSERT_FLOAT_EQ(control.scale(), 0.8f) << i;
  }
  EXPECT_LT(control.rate().value(), 1.0 / 32);
  EXPECT_LE(machine.Cost(control).total(), 55);
}

TEST(RateControl, ResolutionFallsWhereEvenTheFewestSamplesAreTooMany) {
  RateControl control({1, 16}, 1.0f);
  Machine machine{40, 100, 60};
  Observe(&machine, 50, 12, &control);
  EXPECT_LT(control.scale(), 1.0f);
  EXPECT_LE(machine.Cost(control).total(), 55);
}

TEST(RateControl, ResolutionComesBackWhenThereIsRoom) {
  RateControl control({1, 16}, 0.9f);
  Machine slow{40, 300, 160};
  Observe(&slow, 50, 100, &control);
  EXPECT_LE(control.scale(), 0.5f);
  Machine fast{4, 30, 16};
  Observe(&fast, 50, 200, &control);
  EXPECT_FLOAT_EQ(control.scale(), 0.9f) << "the chosen one, and no more";
  EXPECT_GE(control.rate().value(), 0.5);
}

TEST(RateControl, ItNeverLeavesTheChosenResolutionUnlessItMay) {
  RateControl control = Fixed({1, 4}, 0.7f);
  Machine machine{100, 1000, 300};
  for (int i = 0; i < 100; ++i) {
    Observe(&machine, 50, 1, &control);
    ASSERT_FLOAT_EQ(control.scale(), 0.7f);
  }
  control.ChooseScale(0.7f, true);
  Observe(&machine, 50, 40, &control);
  EXPECT_LT(control.scale(), 0.7f);
  EXPECT_GE(control.scale(), 0.7f / 4 - 1e-4f);
  control.ChooseScale(0.7f, false);
  EXPECT_FLOAT_EQ(control.scale(), 0.7f);
}

TEST(RateControl, ASlowFilterCostsResolutionNotSamples) {
  RateControl control({1, 4}, 1.0f);
  for (int i = 0; i < 6; ++i) {
    const float area = control.scale() * control.scale();
    control.Observe({5 * area, 200 * area}, 50);
  }
  EXPECT_LT(control.scale(), 1.0f);
  EXPECT_GE(control.rate().value(), 1.0 / 4);
}

TEST(RateControl, AFallThatDoesNotHelpIsTakenBack) {
  RateControl control = Fixed({1, 8}, 0.25f);
  for (int i = 0; i < 300; ++i) {
    control.Observe({100, 100}, 50);  // whatever is traced: the machine is busy elsewhere
  }
  EXPECT_GE(control.rate().value(), 1.0 / 64);
}

TEST(RateControl, AFastMachineGetsFullResolutionAndManySamples) {
  RateControl control;
  Machine machine{0.5, 3, 2};
  Observe(&machine, 50, 500, &control);
  EXPECT_FLOAT_EQ(control.scale(), 1.0f);
  EXPECT_GE(control.rate().value(), 8);
}

}  // namespace
}  // namespace stillray::view
