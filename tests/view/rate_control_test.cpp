// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "view/rate_control.h"

#include <cmath>

#include <gtest/gtest.h>

namespace stillray::view::rate_control_test {
namespace {

/// A machine: a pixel's guides, a sample and a pixel's filter cost so much.
struct Machine {
  double guides_ms = 10;  // whole picture at scale 1
  double sample_ms = 200;
  double filter_ms = 60;
  double fast_share = 0.25;  // of filter_ms, that the faster filter takes
  double noise = 0;          // part of the time by which frames differ
  int burst = 0;             // every so many frames ...
  int busy = 0;              // ... this many take twice as long: something else runs
  int frame = 0;
  uint32_t state = 1;

  double Noise() {
    state = state * 1664525u + 1013904223u;
    return 1 + noise * (static_cast<double>(state >> 8) / (1 << 24) * 2 - 1);
  }
  FrameCost Cost(const FramePlan& plan) {
    const double area = std::pow(plan.scale, 2.0);
    const bool slow = burst > 0 && frame++ % burst < busy;
    const double factor = Noise() * (slow ? 2 : 1) * area;
    const double fixed = plan.fast_filter && plan.rate.value() < 1 ? 0 : guides_ms * factor;
    return {fixed + sample_ms * plan.rate.value() * factor,
            filter_ms * factor * (plan.fast_filter ? fast_share : 1), fixed};
  }
};

/// Only samples are adaptive; filter and scale are fixed.
RateChoice OnlySamples(double target_ms, float scale) {
  RateChoice choice;
  choice.target_ms = target_ms;
  choice.scale = scale;
  choice.auto_scale = false;
  choice.fast_filter = false;
  return choice;
}

/// Samples and resolution follow, the filter holds.
RateChoice OneFilter(double target_ms, float scale = 1) {
  RateChoice choice = OnlySamples(target_ms, scale);
  choice.auto_scale = true;
  return choice;
}

RateChoice Everything(double target_ms) {
  RateChoice choice = OneFilter(target_ms);
  choice.fast_filter = true;
  return choice;
}

/// \return the plan of the last frame
FramePlan Frames(Machine* machine, const RateChoice& choice, bool moves, int frames,
                 RateControl* control) {
  FramePlan plan;
  for (int i = 0; i < frames; ++i) {
    plan = control->Next(choice, moves, false);
    control->Observe(machine->Cost(plan));
  }
  return plan;
}

/// How often rate, resolution and filter change within so many frames.
struct Changes {
  int rate = 0;
  int scale = 0;
  int filter = 0;
};

Changes CountChanges(Machine* machine, const RateChoice& choice, bool moves, int frames,
                     RateControl* control) {
  Changes changes;
  FramePlan last = Frames(machine, choice, moves, 1, control);
  for (int i = 0; i < frames; ++i) {
    const FramePlan plan = Frames(machine, choice, moves, 1, control);
    changes.rate += plan.rate == last.rate ? 0 : 1;
    changes.scale += plan.scale == last.scale ? 0 : 1;
    changes.filter += plan.fast_filter == last.fast_filter ? 0 : 1;
    last = plan;
  }
  return changes;
}

/// A slider that is dragged ends refinement, but not rest.
TEST(RateControl, IsStillOnceNothingHasMoved) {
  RateControl control({1, 16});
  const RateChoice choice;
  for (int i = 1; i < RateControl::kFramesToRefine; ++i) {
    EXPECT_FALSE(control.Next(choice, false, false).still) << i;
  }
  EXPECT_TRUE(control.Next(choice, false, false).still);
  const FramePlan attended = control.Next(choice, false, true);
  EXPECT_TRUE(attended.still);
  EXPECT_FALSE(attended.refines);
  EXPECT_FALSE(control.Next(choice, true, false).still);
}

TEST(RateControl, FindsTheMostSamplesThatFit) {
  RateControl control({1, 16});
  Machine machine;
  const FramePlan plan = Frames(&machine, OnlySamples(50, 0.5f), true, 60, &control);
  // At half the size: filter 15, guides 2.5; 1/2 sample costs 25, one 50.
  EXPECT_EQ(plan.rate, (SampleRate{1, 2}));
  EXPECT_FLOAT_EQ(plan.scale, 0.5f);
  EXPECT_FALSE(plan.refines);
}

TEST(RateControl, WhatTheUserSetsHolds) {
  RateChoice choice = OnlySamples(50, 0.7f);
  choice.auto_rate = false;
  choice.fast_filter = true;
  choice.rate = {3, 1};
  RateControl control;
  Machine machine;
  for (int i = 0; i < 80; ++i) {
    const FramePlan plan = control.Next(choice, i < 40, i % 3 == 0);
    ASSERT_EQ(plan.rate, (SampleRate{3, 1})) << i;
    ASSERT_FLOAT_EQ(plan.scale, 0.7f) << i;
    ASSERT_FALSE(plan.fast_filter) << i;
    control.Observe(machine.Cost(plan));
  }
}

TEST(RateControl, TheResolutionFollowsWithAFixedRateToo) {
  RateChoice choice = OneFilter(50);
  choice.auto_rate = false;
  choice.rate = {1, 1};
  RateControl control;
  Machine fast{1, 10, 5};
  EXPECT_FLOAT_EQ(Frames(&fast, choice, true, 100, &control).scale, 1);
  Machine slow{10, 200, 60};
  const FramePlan plan = Frames(&slow, choice, true, 100, &control);
  EXPECT_LT(plan.scale, 1);
  EXPECT_LE(slow.Cost(plan).total(), 55);
}

TEST(RateControl, SettlesAndStaysSettled) {
  for (const bool filter_too : {false, true}) {
    for (const double target : {20.0, 33.0, 50.0, 100.0, 250.0}) {
      for (const double sample_ms : {20.0, 90.0, 400.0, 3000.0}) {
        Machine machine;
        machine.sample_ms = sample_ms;
        RateControl control;
        const RateChoice choice = filter_too ? Everything(target) : OneFilter(target);
        const FramePlan plan = Frames(&machine, choice, true, 400, &control);
        const Changes changes = CountChanges(&machine, choice, true, 200, &control);
        EXPECT_EQ(changes.rate, 0) << target << " " << sample_ms;
        EXPECT_EQ(changes.scale, 0) << target << " " << sample_ms;
        EXPECT_EQ(changes.filter, 0) << target << " " << sample_ms;
        EXPECT_LE(machine.Cost(plan).total(), target * 1.1) << target << " " << sample_ms;
      }
    }
  }
}

TEST(RateControl, NoiseDoesNotMakeItSwing) {
  for (const bool filter_too : {false, true}) {
    for (const double target : {20.0, 33.0, 50.0, 100.0}) {
      for (const double sample_ms : {20.0, 90.0, 400.0, 3000.0}) {
        Machine machine;
        machine.sample_ms = sample_ms;
        machine.noise = 0.25;
        RateControl control;
        const RateChoice choice = filter_too ? Everything(target) : OneFilter(target);
        Frames(&machine, choice, true, 600, &control);
        // 1000 frames are 50 seconds at 20 frames per second.
        const Changes changes = CountChanges(&machine, choice, true, 1000, &control);
        EXPECT_LE(changes.rate, 12) << target << " " << sample_ms;
        EXPECT_LE(changes.scale, 4) << target << " " << sample_ms;
        EXPECT_LE(changes.filter, 4) << target << " " << sample_ms;
      }
    }
  }
}

TEST(RateControl, BurstsOfOtherWorkDoNotMakeItSwing) {
  for (const bool filter_too : {false, true}) {
    Machine machine;
    machine.noise = 0.15;
    machine.burst = 60;
    machine.busy = 12;
    RateControl control;
    const RateChoice choice = filter_too ? Everything(50) : OneFilter(50);
    Frames(&machine, choice, true, 600, &control);
    const Changes changes = CountChanges(&machine, choice, true, 1000, &control);
    EXPECT_LE(changes.scale, 6);
    EXPECT_LE(changes.filter, 6);
    EXPECT_LE(changes.rate, 60);  // the rate of samples may follow: its steps cannot be seen
  }
}

TEST(RateControl, FallsAtOnceWhenAFrameIsFarTooLate) {
  RateControl control({4, 1});
  const RateChoice choice = OnlySamples(50, 1);
  control.Next(choice, true, false);
  control.Observe({800, 20});
  EXPECT_LE(control.Next(choice, true, false).rate.value(), 4.0 * 50 / 800);
}

TEST(RateControl, OneLateFrameIsForgiven) {
  RateControl control({1, 4});
  const RateChoice choice = Everything(50);
  for (const FrameCost& cost : {FrameCost{40, 20}, FrameCost{25, 20}, FrameCost{25, 20}}) {
    EXPECT_EQ(control.Next(choice, true, false).rate, (SampleRate{1, 4}));
    control.Observe(cost);
  }
}

TEST(RateControl, TheChosenResolutionStaysWhileFewerSamplesHelp) {
  RateControl control({1, 2});
  const RateChoice choice = OneFilter(50, 0.8f);
  Machine machine{2, 3000, 20};
  FramePlan plan;
  for (int i = 0; i < 200; ++i) {
    plan = Frames(&machine, choice, true, 1, &control);
    ASSERT_FLOAT_EQ(plan.scale, 0.8f) << i;
  }
  EXPECT_LT(plan.rate.value(), 1.0 / 32);
  EXPECT_LE(machine.Cost(plan).total(), 55);
}

TEST(RateControl, ResolutionFallsWhereEvenTheFewestSamplesAreTooMany) {
  RateControl control({1, 16});
  Machine machine{40, 100, 60};
  const FramePlan plan = Frames(&machine, OneFilter(50), true, 13, &control);
  EXPECT_LT(plan.scale, 1.0f);
  EXPECT_LE(machine.Cost(plan).total(), 55);
}

/// Two cores, 907 x 664 pixels: figures of builtin:cornell in ms.
TEST(RateControl, TheFasterFilterComesBeforeALowerResolution) {
  RateControl control;
  Machine machine{70, 280, 110, 0.28};
  FramePlan plan = Frames(&machine, Everything(50), true, 60, &control);
  EXPECT_TRUE(plan.fast_filter);
  EXPECT_FLOAT_EQ(plan.scale, 1);
  EXPECT_LE(machine.Cost(plan).total(), 50);
  Machine slower{280, 1100, 440, 0.28};
  plan = Frames(&slower, Everything(50), true, 60, &control);
  EXPECT_TRUE(plan.fast_filter);
  EXPECT_LT(plan.scale, 1);
  EXPECT_LE(slower.Cost(plan).total(), 55);
}

TEST(RateControl, TheChosenFilterComesBackWhenThereIsRoom) {
  RateControl control;
  Machine slow{70, 280, 110};
  EXPECT_TRUE(Frames(&slow, Everything(50), true, 60, &control).fast_filter);
  Machine fast{7, 28, 11};
  const FramePlan plan = Frames(&fast, Everything(50), true, 60, &control);
  EXPECT_FALSE(plan.fast_filter);
  EXPECT_FLOAT_EQ(plan.scale, 1);
}

TEST(RateControl, AViewThatStandsStillRefines) {
  RateControl control;
  Machine machine{70, 280, 110, 0.28};
  Frames(&machine, Everything(50), true, 60, &control);
  for (int i = 0; i < RateControl::kFramesToRefine - 1; ++i) {
    const FramePlan plan = Frames(&machine, Everything(50), false, 1, &control);
    EXPECT_FALSE(plan.refines) << "a pause of the hand is no rest";
  }
  FramePlan plan = Frames(&machine, Everything(50), false, 1, &control);
  EXPECT_TRUE(plan.refines);
  EXPECT_FALSE(plan.fast_filter);
  EXPECT_FLOAT_EQ(plan.scale, 1);
  plan = Frames(&machine, Everything(50), false, 3, &control);
  EXPECT_GE(plan.rate.value(), 1);
  const Changes changes = CountChanges(&machine, Everything(50), false, 200, &control);
  EXPECT_EQ(changes.rate + changes.scale + changes.filter, 0);
  // At once fast again when something moves.
  plan = control.Next(Everything(50), true, false);
  EXPECT_TRUE(plan.fast_filter);
  EXPECT_FALSE(plan.refines);
  EXPECT_LE(machine.Cost(plan).total(), 55);
}

TEST(RateControl, ARefiningViewSpendsItsTimeOnSamplesNotOnTheFilter) {
  RateControl control;
  Machine machine{5, 20, 400};
  const FramePlan plan = Frames(&machine, Everything(50), false, 60, &control);
  EXPECT_GE(plan.rate.value(), 8);
  EXPECT_LE(machine.Cost(plan).trace_ms, 400);
}

TEST(RateControl, ASampleThatTakesTooLongIsSpreadOverFrames) {
  RateControl control;
  Machine machine{100, 8000, 400};
  const FramePlan plan = Frames(&machine, Everything(50), false, 30, &control);
  EXPECT_TRUE(plan.refines);
  EXPECT_LT(plan.rate.value(), 1);
  EXPECT_LE(machine.Cost(plan).total(), 1600);
}

TEST(RateControl, NoiseDoesNotMakeARefiningViewSwing) {
  for (const double sample_ms : {1.0, 20.0, 280.0, 900.0, 5000.0}) {
    Machine machine{70, sample_ms, 110};
    machine.noise = 0.2;
    RateControl control;
    Frames(&machine, Everything(50), false, 50, &control);
    EXPECT_LE(CountChanges(&machine, Everything(50), false, 300, &control).rate, 12) << sample_ms;
  }
}

/// A slider that is dragged: answers come soon, and nothing that was gathered is lost.
TEST(RateControl, WhileTheUserChangesSettingsFramesAnswerSoon) {
  RateControl control;
  Machine machine{20, 800, 60};
  Frames(&machine, Everything(50), false, 30, &control);
  const FramePlan plan = control.Next(Everything(50), false, true);
  EXPECT_FALSE(plan.refines);
  EXPECT_FALSE(plan.fast_filter);
  EXPECT_FLOAT_EQ(plan.scale, 1);
  EXPECT_LE(machine.Cost(plan).total(), 140);
  control.Observe(machine.Cost(plan));
  const FramePlan next = control.Next(Everything(50), false, false);
  EXPECT_TRUE(next.refines);
  EXPECT_GE(next.rate.value(), 0.5);
}

TEST(RateControl, AFastMachineMovesAsItStands) {
  RateControl control;
  Machine machine{0.5, 3, 2};
  FramePlan plan = Frames(&machine, Everything(50), true, 500, &control);
  EXPECT_FLOAT_EQ(plan.scale, 1.0f);
  EXPECT_FALSE(plan.fast_filter);
  EXPECT_GE(plan.rate.value(), 8);
  plan = Frames(&machine, Everything(50), false, 100, &control);
  EXPECT_LE(machine.Cost(plan).total(), 55)
      << "one sample per pixel fits: there is no need to wait";
  plan = Frames(&machine, Everything(50), true, 1, &control);
  EXPECT_FALSE(plan.fast_filter);
  EXPECT_GE(plan.rate.value(), 8);
}

TEST(RateControl, ResolutionComesBackWhenThereIsRoom) {
  RateControl control({1, 16});
  Machine slow{40, 300, 160};
  EXPECT_LE(Frames(&slow, OneFilter(50, 0.9f), true, 100, &control).scale, 0.5f);
  Machine fast{4, 30, 16};
  const FramePlan plan = Frames(&fast, OneFilter(50, 0.9f), true, 200, &control);
  EXPECT_FLOAT_EQ(plan.scale, 0.9f) << "the chosen one, and no more";
  EXPECT_GE(plan.rate.value(), 0.5);
}

TEST(RateControl, ItNeverLeavesTheChosenResolutionUnlessItMay) {
  RateControl control({1, 4});
  Machine machine{100, 1000, 300};
  for (int i = 0; i < 100; ++i) {
    ASSERT_FLOAT_EQ(Frames(&machine, OnlySamples(50, 0.7f), true, 1, &control).scale, 0.7f);
  }
  const FramePlan plan = Frames(&machine, OneFilter(50, 0.7f), true, 40, &control);
  EXPECT_LT(plan.scale, 0.7f);
  EXPECT_GE(plan.scale, 0.7f / 4 - 1e-4f);
  EXPECT_FLOAT_EQ(control.Next(OnlySamples(50, 0.7f), true, false).scale, 0.7f);
}

TEST(RateControl, ASlowFilterCostsResolutionNotSamples) {
  RateControl control({1, 4});
  FramePlan plan;
  for (int i = 0; i < 7; ++i) {
    plan = control.Next(OneFilter(50), true, false);
    const double area = static_cast<double>(plan.scale * plan.scale);
    control.Observe({5 * area, 200 * area});
  }
  EXPECT_LT(plan.scale, 1.0f);
  EXPECT_GE(plan.rate.value(), 1.0 / 4);
}

TEST(RateControl, AFallThatDoesNotHelpIsTakenBack) {
  RateControl control({1, 8});
  FramePlan plan;
  for (int i = 0; i < 300; ++i) {
    plan = control.Next(OnlySamples(50, 0.25f), true, false);
    control.Observe({100, 100});  // independent of the samples: the machine is busy elsewhere
  }
  EXPECT_GE(plan.rate.value(), 1.0 / 64);
}

// Traced while the last frame is filtered: the slower part alone takes the time.
TEST(RateControl, OverlappedPartsAreNotAdded) {
  EXPECT_EQ((FrameCost{30, 40, 10, true}.total()), 40);
  EXPECT_EQ((FrameCost{60, 40, 10, true}.total()), 60);
  EXPECT_EQ((FrameCost{30, 40, 10, false}.total()), 70);
  for (const bool overlapped : {false, true}) {
    RateControl control({1, 8});
    FramePlan plan;
    for (int i = 0; i < 3; ++i) {  // late twice in a row: samples fall
      plan = control.Next(OnlySamples(50, 1), true, false);
      control.Observe({30, 40, 10, overlapped});
    }
    EXPECT_EQ(plan.rate == (SampleRate{1, 8}), overlapped) << plan.rate.value();
  }
  // 10 ms and 190 ms for the samples: an eighth of them fits into 50 ms, beside a filter of 45 ms.
  RateControl control({1, 4});
  control.Next(OnlySamples(50, 1), true, false);
  control.Observe({200, 45, 10, true});
  EXPECT_EQ(control.Next(OnlySamples(50, 1), true, false).rate, (SampleRate{1, 32}));
}

TEST(RateControl, TheSameCostsGiveTheSamePlans) {
  RateControl controls[2];
  for (int i = 0; i < 300; ++i) {
    FramePlan plans[2];
    for (int k = 0; k < 2; ++k) {
      plans[k] = controls[k].Next(Everything(50), i % 90 < 60, i % 7 == 0);
      controls[k].Observe({20.0 + i % 50, 30.0 + i % 20, 5});
    }
    ASSERT_EQ(plans[0].rate, plans[1].rate);
    ASSERT_EQ(plans[0].scale, plans[1].scale);
    ASSERT_EQ(plans[0].fast_filter, plans[1].fast_filter);
    ASSERT_EQ(plans[0].refines, plans[1].refines);
  }
}

}  // namespace
}  // namespace stillray::view::rate_control_test
