// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Updating the history in place must give the same bits as writing a new one.
#include "denoise/stages/accumulate.h"

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include "denoise/cpu/fused/fused.h"
#include "denoise/planes.h"
#include "denoise/stages/reproject.h"
#include "stage_planes.h"

namespace stillray::accumulate_test {
namespace {

using test::DifferentBits;
using test::kHeight;
using test::kWidth;
using test::MakeGuides;
using test::MakeHistory;
using test::MakeLight;

int DifferentBits(const SignalHistory& a, const SignalHistory& b) {
  int count = DifferentBits(a.mean, b.mean) + DifferentBits(a.variance, b.variance) +
              DifferentBits(a.length, b.length) + DifferentBits(a.weights2, b.weights2) +
              DifferentBits(a.compressed, b.compressed);
  for (int c = 0; c < 3; ++c) {
    count += DifferentBits(a.colour[c], b.colour[c]) + DifferentBits(a.behind[c], b.behind[c]);
  }
  return count;
}

/// \param shift  of the whole picture, pixels
void Compare(float shift, bool lit_alone, bool mostly_still, bool confident = true) {
  const GuidePlanes before = MakeGuides(false);
  const GuidePlanes now = MakeGuides(true);
  Image2 motion(kWidth, kHeight);
  motion[0].Fill(shift);
  const NewLight light = MakeLight();
  const AccumulateParameters& p = test::DefaultPlan().accumulate;
  Image1 limit(kWidth, kHeight);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      limit(x, y) = 6 * test::Random(x, y, 30);
    }
  }
  Image1 ratio(kWidth, kHeight);
  ratio.Fill(1);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      // As limit_history leaves it: 1 where there is no sample.
      ratio(x, y) = light.samples(x, y) > 0 ? 0.5f + test::Random(x, y, 31) : 1.0f;
    }
  }
  const HistoryLimits limits = {&limit, &ratio};
  Image1 confidence(kWidth, kHeight);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      confidence(x, y) = 2 * test::Random(x, y, 32) - 0.5f;  // a quarter each below 0 and above 1
    }
  }
  for (const int64_t target : hwy::SupportedAndGeneratedTargets()) {
    hwy::SetSupportedTargetsForTest(target);
    ReprojectionTaps taps(kWidth, kHeight);
    EXPECT_EQ(taps.GatherCount(), -1);
    cpu::FindTaps(now, before, motion, test::DefaultPlan().reproject, &taps);
    taps.confidence = confident ? nullptr : &confidence;
    const int64_t gathers = taps.GatherCount();
    EXPECT_GT(gathers, 0);
    const int64_t vectors =
        static_cast<int64_t>(kHeight) * ((kWidth + taps.lanes - 1) / taps.lanes);
    EXPECT_EQ(2 * gathers < vectors, mostly_still);
    // Capacity for all: only the bits are tested.
    StagedHistory staged(8 * kWidth + 8 * taps.lanes, kHeight);
    ASSERT_TRUE(staged.HasRoom(static_cast<size_t>(gathers), taps.lanes));
    const SignalHistory old = MakeHistory(lit_alone);
    SignalHistory anew = old;
    cpu::Accumulate(light, old, &taps, limits, p, &anew);
    SignalHistory in_place = old;
    cpu::AccumulateInPlace(light, taps, limits, p, lit_alone, &staged, &in_place);
    EXPECT_EQ(DifferentBits(anew, in_place), 0) << hwy::TargetName(target);
    EXPECT_GT(DifferentBits(old, in_place), 0);
  }
  hwy::SetSupportedTargetsForTest(0);
}

TEST(AccumulateInPlace, SameBitsInAStillView) {
  Compare(0, true, true);
}

TEST(AccumulateInPlace, ForgetsWhatWasFedBackToPixelsWithoutSamples) {
  Compare(0, false, true);
}

TEST(AccumulateInPlace, SameBitsWhereEverythingMoves) {
  Compare(1.25f, true, false);
  Compare(2.0f, true, false);
}

TEST(AccumulateInPlace, SameBitsUnderAConfidence) {
  Compare(0, true, true, false);
  Compare(0, false, true, false);
  Compare(1.25f, true, false, false);
}

}  // namespace
}  // namespace stillray::accumulate_test
