// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The history that is changed in place must be the very bits of the one that is written anew.
#include "denoise/stages/accumulate.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include "core/random.h"
#include "denoise/planes.h"
#include "denoise/stages/prepare_guides.h"
#include "denoise/stages/reproject.h"

namespace stillray {
namespace {

constexpr int kWidth = 83;
constexpr int kHeight = 37;

float Random(int x, int y, uint32_t what) {
  return UniformFloat(
      HashCombine(HashCombine(static_cast<uint32_t>(x), static_cast<uint32_t>(y)), what));
}

/// A wall and some sky; a few pixels of the frame before show something behind it.
GuidePlanes MakeGuides(bool now) {
  Image1 depth(kWidth, kHeight);
  Image3 normal(kWidth, kHeight);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const bool sky = y < 3 || Random(x / 9, y / 9, 1) < 0.1f;
      const bool changed = !now && Random(x, y, 2) < 0.01f;
      depth(x, y) = sky ? std::numeric_limits<float>::infinity() : changed ? 9.0f : 4.0f;
      normal[2](x, y) = sky ? 0.0f : 1.0f;
    }
  }
  GuidePlanes guides(kWidth, kHeight, 16);
  cpu::PrepareGuides({&depth, &normal, nullptr}, &guides);
  return guides;
}

/// \param lit_alone  pixels without samples have no light
SignalHistory MakeHistory(bool lit_alone) {
  SignalHistory history(kWidth, kHeight, false, true, 16);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const bool lit = Random(x, y, 3) < 0.7f;
      history.length(x, y) = lit ? 1.0f + std::floor(5 * Random(x, y, 4)) : 0.0f;
      for (uint32_t c = 0; c < 3; ++c) {
        history.colour[static_cast<int>(c)](x, y) = lit || !lit_alone ? Random(x, y, 5 + c) : 0.0f;
        history.behind[static_cast<int>(c)](x, y) = lit || !lit_alone ? Random(x, y, 8 + c) : 0.0f;
      }
      history.mean(x, y) = lit ? Random(x, y, 11) : 0.0f;
      history.variance(x, y) = lit ? Random(x, y, 12) : 0.0f;
      history.weights2(x, y) = lit ? Random(x, y, 13) : 0.0f;
    }
  }
  return history;
}

NewLight MakeLight() {
  NewLight light = {Image3(kWidth, kHeight), Image1(kWidth, kHeight), Image1()};
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      if (Random(x, y, 20) < 0.03f) {
        light.samples(x, y) = 1;
        for (uint32_t c = 0; c < 3; ++c) {
          light.colour[static_cast<int>(c)](x, y) = 3 * Random(x, y, 21 + c);
        }
      }
    }
  }
  return light;
}

int DifferentBits(const Image1& a, const Image1& b) {
  int count = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      // A zero that keeps its sign is no other number.
      count += a(x, y) != b(x, y) ? 1 : 0;
    }
  }
  return count;
}

int DifferentBits(const SignalHistory& a, const SignalHistory& b) {
  int count = DifferentBits(a.mean, b.mean) + DifferentBits(a.variance, b.variance) +
              DifferentBits(a.length, b.length) + DifferentBits(a.weights2, b.weights2);
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
  for (int64_t targets = hwy::SupportedTargets(); targets != 0; targets &= targets - 1) {
    hwy::SetSupportedTargetsForTest(targets & -targets);
    ReprojectionTaps taps(kWidth, kHeight);
    EXPECT_EQ(taps.Elsewhere(), -1);
    cpu::FindTaps(now, before, motion, {}, &taps);
    const int64_t elsewhere = taps.Elsewhere();
    EXPECT_GT(elsewhere, 0);
    const int64_t vectors =
        static_cast<int64_t>(kHeight) * ((kWidth + taps.lanes - 1) / taps.lanes);
    EXPECT_EQ(2 * elsewhere < vectors, mostly_still);
    // Room for all: what is under test is the bits.
    StagedHistory staged(8 * kWidth + 8 * taps.lanes, kHeight);
    ASSERT_TRUE(staged.HasRoom(static_cast<size_t>(elsewhere), taps.lanes));
    const SignalHistory old = MakeHistory(lit_alone);
    SignalHistory anew = old;
    p.lit_alone = false;
    cpu::Accumulate(light, old, &taps, nullptr, p, &anew);
    SignalHistory in_place = old;
    p.lit_alone = lit_alone;
    cpu::AccumulateInPlace(light, taps, p, &staged, &in_place);
    EXPECT_EQ(DifferentBits(anew, in_place), 0) << hwy::TargetName(targets & -targets);
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
  cpu::AccumulateInPlace(light, taps, p, &staged, &vectors);
  reference::AccumulateInPlace(light, reference_taps, p, nullptr, &scalar);
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
