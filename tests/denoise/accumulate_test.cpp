// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Updating the history in place must give the same bits as writing a new one.
#include "denoise/stages/accumulate.h"

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include "denoise/planes.h"
#include "denoise/stages/reproject.h"
#include "stage_planes.h"

namespace stillray {
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
void Compare(float shift, bool lit_alone, bool mostly_still) {
  const GuidePlanes before = MakeGuides(false);
  const GuidePlanes now = MakeGuides(true);
  Image2 motion(kWidth, kHeight);
  motion[0].Fill(shift);
  const NewLight light = MakeLight();
  AccumulateParameters p;
  p.compressed_scale = 0.5f;
  Image1 limit(kWidth, kHeight);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      limit(x, y) = 6 * test::Random(x, y, 30);
    }
  }
  for (const int64_t target : hwy::SupportedAndGeneratedTargets()) {
    hwy::SetSupportedTargetsForTest(target);
    ReprojectionTaps taps(kWidth, kHeight);
    EXPECT_EQ(taps.Elsewhere(), -1);
    cpu::FindTaps(now, before, motion, {}, &taps);
    const int64_t elsewhere = taps.Elsewhere();
    EXPECT_GT(elsewhere, 0);
    const int64_t vectors =
        static_cast<int64_t>(kHeight) * ((kWidth + taps.lanes - 1) / taps.lanes);
    EXPECT_EQ(2 * elsewhere < vectors, mostly_still);
    // Capacity for all: only the bits are tested.
    StagedHistory staged(8 * kWidth + 8 * taps.lanes, kHeight);
    ASSERT_TRUE(staged.HasRoom(static_cast<size_t>(elsewhere), taps.lanes));
    const SignalHistory old = MakeHistory(lit_alone);
    SignalHistory anew = old;
    p.lit_alone = false;
    cpu::Accumulate(light, old, &taps, &limit, p, &anew);
    SignalHistory in_place = old;
    p.lit_alone = lit_alone;
    cpu::AccumulateInPlace(light, taps, &limit, p, &staged, &in_place);
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

/// The reference changes in place, too.
TEST(AccumulateInPlace, ReferenceAgrees) {
  const GuidePlanes before = MakeGuides(false);
  const GuidePlanes now = MakeGuides(true);
  const Image2 motion(kWidth, kHeight);
  const NewLight light = MakeLight();
  ReprojectionTaps taps(kWidth, kHeight);
  ReprojectionTaps reference_taps(kWidth, kHeight);
  cpu::FindTaps(now, before, motion, {}, &taps);
  reference::FindTaps(now, before, motion, {}, &reference_taps);
  EXPECT_EQ(reference_taps.Elsewhere(), -1);
  StagedHistory staged(8 * kWidth + 128, kHeight);
  SignalHistory vectors = MakeHistory(true);
  SignalHistory scalar = vectors;
  AccumulateParameters p;
  p.lit_alone = true;
  cpu::AccumulateInPlace(light, taps, nullptr, p, &staged, &vectors);
  reference::AccumulateInPlace(light, reference_taps, nullptr, p, nullptr, &scalar);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      ASSERT_EQ(vectors.length(x, y), scalar.length(x, y)) << x << " " << y;
      ASSERT_NEAR(vectors.colour[0](x, y), scalar.colour[0](x, y), 1e-5f) << x << " " << y;
      ASSERT_NEAR(vectors.behind[2](x, y), scalar.behind[2](x, y), 1e-5f) << x << " " << y;
      ASSERT_NEAR(vectors.variance(x, y), scalar.variance(x, y), 1e-5f) << x << " " << y;
      ASSERT_NEAR(vectors.weights2(x, y), scalar.weights2(x, y), 1e-5f) << x << " " << y;
    }
  }
}

}  // namespace
}  // namespace stillray
