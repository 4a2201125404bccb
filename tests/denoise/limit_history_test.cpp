// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/stages/limit_history.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include "denoise/stage_table.h"
#include "denoise/stages/atrous.h"
#include "stage_planes.h"

namespace stillray {
namespace {

using test::kHeight;
using test::kWidth;

constexpr int kSignals = 3;
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

struct Limited {
  FilterPlanes filter[2] = {{kWidth, kHeight, 16}, {kWidth, kHeight, 16}};
  Image1 valid = Image1(kWidth, kHeight, 16);
  Image1 limit = Image1(kWidth, kHeight, 16);
};

ReprojectionTaps FindTaps(const StageTable& stages, float shift) {
  Image2 motion(kWidth, kHeight);
  motion[0].Fill(shift);
  ReprojectionTaps taps(kWidth, kHeight);
  stages.find_taps(test::MakeGuides(true), test::MakeGuides(false), motion,
                   test::DefaultPlan().reproject, &taps);
  return taps;
}

/// All of limit_history, as the denoiser calls it, on planes that hold something from before.
std::array<Limited, kSignals> RunStage(const StageTable& stages, float shift, float lit,
                                       float sigma_n) {
  const GuidePlanes guides = test::MakeGuides(true);
  const SignalHistory history = test::MakeHistory(true);
  const ReprojectionTaps taps = FindTaps(stages, shift);
  const LimitHistoryParameters p = {.limit_dead = 0, .limit_gain = 16};
  AtrousParameters geometry = test::DefaultPlan().atrous;
  geometry.edges.sigma_n = sigma_n;
  std::array<Limited, kSignals> all;
  std::array<AtrousSignal, kSignals> signals;
  for (uint32_t i = 0; i < kSignals; ++i) {
    for (FilterPlanes& filter : all[i].filter) {
      filter.colour[0].Fill(kNan);
      filter.variance.Fill(kNan);
    }
    all[i].valid.Fill(1);
    stages.compare_with_history(test::MakeLight(lit, 40 + 10 * i), history, taps, guides,
                                &all[i].filter[0], &all[i].valid);
  }
  for (int level = 0; level < kLimitHistoryLevels; ++level) {
    for (size_t i = 0; i < kSignals; ++i) {
      FilterPlanes* filter = all[i].filter;
      const int from = level % 2;
      signals[i] = {&filter[from].colour, &filter[from].variance, &filter[1 - from], &all[i].limit,
                    &all[i].valid};
    }
    stages.atrous(signals, guides, GeometryLevel(level), geometry);
  }
  for (Limited& one : all) {
    stages.limit_history(one.filter[1], one.valid, history, taps, p, &one.limit);
  }
  return all;
}

/// How many pixels are not within 1e-4 and 1 % of each other, of those where there is something.
int FarOff(const Image1& a, const Image1& b, const Image1* valid = nullptr) {
  int count = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const float difference = std::abs(a(x, y) - b(x, y));
      const bool counts = valid == nullptr || (*valid)(x, y) > 0;
      count += counts && !(difference <= 1e-4f + 0.01f * std::abs(b(x, y))) ? 1 : 0;
    }
  }
  return count;
}

int Count(const Image1& plane) {
  int count = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      count += plane(x, y) != 0 ? 1 : 0;
    }
  }
  return count;
}

/// \param lit  share of the pixels that have a sample
void Compare(float shift, float lit, float sigma_n) {
  const auto expected = RunStage(kReferenceStages, shift, lit, sigma_n);
  EXPECT_GT(Count(expected[0].valid), 0.3f * lit * kWidth * kHeight);
  for (const int64_t target : hwy::SupportedAndGeneratedTargets()) {
    hwy::SetSupportedTargetsForTest(target);
    const auto got = RunStage(kCpuStages, shift, lit, sigma_n);
    for (size_t i = 0; i < kSignals; ++i) {
      SCOPED_TRACE(hwy::TargetName(target));
      const FilterPlanes& filtered = got[i].filter[1];
      EXPECT_EQ(FarOff(got[i].valid, expected[i].valid), 0);
      EXPECT_EQ(FarOff(filtered.colour[0], expected[i].filter[1].colour[0], &got[i].valid), 0);
      EXPECT_EQ(FarOff(filtered.colour[1], expected[i].filter[1].colour[1], &got[i].valid), 0);
      EXPECT_EQ(FarOff(filtered.variance, expected[i].filter[1].variance, &got[i].valid), 0);
      // Where the difference is about its noise, rounding decides how much of it counts.
      EXPECT_LE(FarOff(got[i].limit, expected[i].limit), kWidth * kHeight / 500);
    }
  }
  hwy::SetSupportedTargetsForTest(0);
}

TEST(LimitHistoryStage, VersionsAgree) {
  Compare(0, 0.9f, 128);
  Compare(1.25f, 0.9f, 128);
  Compare(1.25f, 0.9f, 32);
}

TEST(LimitHistoryStage, VersionsAgreeWhereSamplesAreRare) {
  Compare(0, 0.05f, 128);
  Compare(1.25f, 0.05f, 128);
}

/// A pixel without a sample or a history keeps its length, and lends nothing to others.
TEST(LimitHistoryStage, WhatIsMissingCountsForNothing) {
  const auto all = RunStage(kCpuStages, 0, 0.5f, 128);
  SignalHistory history = test::MakeHistory(true);
  cpu::FetchHistory(test::MakeHistory(true), FindTaps(kCpuStages, 0), &history);
  int shortened = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      if (!(all[1].valid(x, y) > 0)) {
        EXPECT_EQ(all[1].limit(x, y), history.length(x, y)) << x << " " << y;
      }
      shortened += all[1].limit(x, y) < 0.5f * history.length(x, y) ? 1 : 0;
    }
  }
  EXPECT_GT(shortened, 100);
}

}  // namespace
}  // namespace stillray
