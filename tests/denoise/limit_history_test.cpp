// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/stages/limit_history.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include "denoise/stage_table.h"
#include "denoise/stages/atrous.h"
#include "denoise/stages/select_guides_shared.h"
#include "denoise/test_frames.h"
#include "every_target.h"
#include "stage_planes.h"
#include "stage_test.h"

namespace stillray::limit_history_test {
namespace {

using test::kHeight;
using test::kWidth;

constexpr uint32_t kSignals = 3;
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

ReprojectionTaps FindTaps(const StageTable& stages, const GuidePlanes& now,
                          const GuidePlanes& before, float shift) {
  Image2 motion(kWidth, kHeight);
  motion[0].Fill(shift);
  ReprojectionTaps taps(kWidth, kHeight);
  stages.find_taps(now, before, motion, test::DefaultPlan().reproject, &taps);
  return taps;
}

ReprojectionTaps FindTaps(const StageTable& stages, float shift) {
  return FindTaps(stages, test::MakeGuides(true), test::MakeGuides(false), shift);
}

LimitHistoryParameters Limits(int correct_history, float dead, float gain, float jitter_x = 0) {
  LimitHistoryParameters p = {};
  p.correct_history = correct_history;
  p.limit_dead = dead;
  p.limit_gain = gain;
  p.jitter_x = jitter_x;
  return p;
}

struct Limited {
  GuidePlanes coarse = GuidePlanes(CoarseSize(kWidth), CoarseSize(kHeight), kComparedBorder);
  std::vector<ComparedPlanes> compared;
  std::vector<Image1> ratio, bias;
};

void RunLevels(const StageTable& stages, int levels, Limited* all) {
  std::array<AtrousSignal, kSignals> signals;
  const size_t count = all->compared.size();
  for (int level = 0; level < levels; ++level) {
    for (size_t i = 0; i < count; ++i) {
      ComparedPlanes& c = all->compared[i];
      const FilterPlanes& from = level % 2 == 0 ? c.light : c.work;
      signals[i] = {&from.colour, &from.variance, level % 2 == 0 ? &c.work : &c.light, nullptr,
                    &c.valid};
    }
    stages.atrous({signals.data(), count}, all->coarse, ComparedLevel(level),
                  test::DefaultPlan().compared);
  }
}

/// The wide change of every signal.
void RunWideLevel(const StageTable& stages, Limited* all) {
  for (ComparedPlanes& c : all->compared) {
    stages.measure_change(c.work, &c);
    const AtrousSignal signal = {&c.light.colour, &c.light.variance, &c.wide, nullptr, &c.valid};
    stages.atrous({&signal, 1}, all->coarse, kWideLevel, test::DefaultPlan().compared);
  }
}

/// All of limit_history, as the denoiser runs it.
Limited RunStage(const StageTable& stages, const std::vector<NewLight>& light,
                 const SignalHistory& history, const ReprojectionTaps& taps,
                 const GuidePlanes& guides, const LimitHistoryParameters& p,
                 const Image1& roughness = {}, float moving = 0) {
  Limited all;
  const size_t count = light.size();
  all.compared.assign(count, ComparedPlanes(CoarseSize(kWidth), CoarseSize(kHeight)));
  all.ratio.assign(count, Image1(kWidth, kHeight));
  all.bias = all.ratio;
  std::vector<ComparedSignal> signals;
  std::vector<LimitedSignal> limited;
  for (size_t i = 0; i < count; ++i) {
    // Something from before.
    all.ratio[i].Fill(kNan);
    all.bias[i].Fill(kNan);
    signals.push_back({&light[i], &history, &all.compared[i]});
    limited.push_back({&all.compared[i], &light[i].samples, &all.ratio[i], &all.bias[i]});
  }
  stages.compare_with_history(signals, taps, guides, roughness, &all.coarse);
  RunLevels(stages, kCorrectHistoryLevels, &all);
  RunWideLevel(stages, &all);
  for (size_t i = 0; i < count; ++i) {
    ComparedPlanes& compared = all.compared[i];
    compared.moving = i == 0 ? moving : 0.0f;
    stages.correct_history(compared.work, p, &compared);
  }
  RunLevels(stages, kLimitHistoryLevels, &all);
  for (size_t i = 0; i < count; ++i) {
    ComparedPlanes& compared = all.compared[i];
    MeasureBias(compared.light, (p.fine_signals >> i & 1) != 0 ? &compared.work : nullptr, p,
                &compared);
  }
  stages.limit_history(limited, all.coarse, guides);
  return all;
}

Limited RunBusy(const StageTable& stages, float shift, float lit) {
  std::vector<NewLight> light;
  for (uint32_t i = 0; i < kSignals; ++i) {
    light.push_back(test::MakeLight(lit, 40 + 10 * i));
  }
  LimitHistoryParameters p = Limits(1, 0, 16, 0.25f);
  p.fine_signals = 5;
  return RunStage(stages, light, test::MakeHistory(true), FindTaps(stages, shift),
                  test::MakeGuides(true), p, {}, 0.5f);
}

/// How many pixels are not within 1e-4 and 1 % of each other, of those where there is something.
int FarOff(const Image1& a, const Image1& b, const Image1* valid = nullptr) {
  int count = 0;
  for (int y = 0; y < a.height(); ++y) {
    for (int x = 0; x < a.width(); ++x) {
      const float difference = std::abs(a(x, y) - b(x, y));
      const bool counts = valid == nullptr || (*valid)(x, y) > 0;
      count += counts && !(difference <= 1e-4f + 0.01f * std::abs(b(x, y))) ? 1 : 0;
    }
  }
  return count;
}

int Count(const Image1& plane) {
  int count = 0;
  for (int y = 0; y < plane.height(); ++y) {
    for (int x = 0; x < plane.width(); ++x) {
      count += plane(x, y) != 0 ? 1 : 0;
    }
  }
  return count;
}

/// \param lit  share of the pixels that have a sample
void Compare(float shift, float lit) {
  const Limited expected = RunBusy(kReferenceStages, shift, lit);
  EXPECT_GT(Count(expected.compared[0].valid), 0.3f * lit * kWidth * kHeight / 4);
  EXPECT_GT(Count(expected.bias[0]), 0.01f * lit * kWidth * kHeight);
  for (const int64_t target : hwy::SupportedAndGeneratedTargets()) {
    hwy::SetSupportedTargetsForTest(target);
    const Limited got = RunBusy(kCpuStages, shift, lit);
    SCOPED_TRACE(hwy::TargetName(target));
    EXPECT_EQ(FarOff(got.coarse.inverse_depth, expected.coarse.inverse_depth), 0);
    for (int c = 0; c < 3; ++c) {
      EXPECT_EQ(FarOff(got.coarse.normal[c], expected.coarse.normal[c]), 0);
    }
    for (size_t i = 0; i < kSignals; ++i) {
      const ComparedPlanes& a = got.compared[i];
      const ComparedPlanes& b = expected.compared[i];
      EXPECT_EQ(FarOff(a.valid, b.valid), 0);
      for (int c = 0; c < 3; ++c) {
        EXPECT_EQ(FarOff(a.compressed.colour[c], b.compressed.colour[c]), 0) << c;
      }
      EXPECT_EQ(FarOff(a.compressed.variance, b.compressed.variance), 0);
      EXPECT_EQ(FarOff(a.ratio, b.ratio), 0);
      EXPECT_EQ(FarOff(got.ratio[i], expected.ratio[i]), 0);
      // Where the difference is about its noise, rounding decides how much of it counts.
      EXPECT_LE(FarOff(got.bias[i], expected.bias[i]), kWidth * kHeight / 100);
    }
  }
  hwy::SetSupportedTargetsForTest(0);
}

TEST(LimitHistoryStage, VersionsAgree) {
  Compare(0, 0.9f);
  Compare(1.25f, 0.9f);
}

TEST(LimitHistoryStage, VersionsAgreeWhereSamplesAreRare) {
  Compare(0, 0.05f);
  Compare(1.25f, 0.05f);
}

/// A pixel without a sample keeps its history, and lends nothing to others.
TEST(LimitHistoryStage, PixelsWithoutSamplesKeepTheirHistory) {
  const Limited all = RunBusy(kCpuStages, 0, 0.5f);
  const NewLight light = test::MakeLight(0.5f, 50);
  int without = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      if (!(light.samples(x, y) > 0)) {
        ASSERT_EQ(all.ratio[1](x, y), 1) << x << " " << y;
        ASSERT_EQ(all.bias[1](x, y), 0) << x << " " << y;
        ++without;
      }
    }
  }
  EXPECT_GT(without, kWidth * kHeight / 4);
}

/// Walls that face the camera. \param depth_of  the depth of a column
GuidePlanes MakeWalls(const std::function<float(int)>& depth_of) {
  Image1 depth(kWidth, kHeight);
  Image3 normal(kWidth, kHeight);
  normal[2].Fill(1);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      depth(x, y) = depth_of(x);
    }
  }
  GuidePlanes guides(kWidth, kHeight, 16);
  guides.turn2 = Image1(kWidth, kHeight);
  cpu::PrepareGuides({&depth, &normal, nullptr}, &guides);
  return guides;
}

/// A wall, left of `edge` at depth 4, right of it at depth 8.
GuidePlanes MakeWalls(int edge) {
  return MakeWalls([&](int x) { return x < edge ? 4.0f : 8.0f; });
}

/// A history of twenty samples of MakeNoise(1, 1, ...).
SignalHistory MakeSteadyHistory(float noise) {
  SignalHistory history(kWidth, kHeight, true, false, 16);
  history.compressed_scale = 1;
  for (int c = 0; c < 3; ++c) {
    history.colour[c].Fill(1);
  }
  history.mean.Fill(1);
  history.variance.Fill(noise * noise / 3);
  history.length.Fill(20);
  history.weights2.Fill(0.05f);
  // The mean of x / (1 + x) over the range of a sample x.
  history.compressed.Fill(1 - std::log((2 + noise) / (2 - noise)) / (2 * noise));
  return history;
}

/// \param noise  samples are uniform within this of the mean
NewLight MakeNoise(float left, float right, int edge, float noise) {
  NewLight light = {LumaImage3(kWidth, kHeight), Image1(kWidth, kHeight), Image1()};
  light.samples.Fill(1);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const float mean = x < edge ? left : right;
      light.colour[0](x, y) = mean * (1 + noise * (2 * test::Random(x, y, 90) - 1));
    }
  }
  return light;
}

TEST(LimitHistoryStage, LightThatChangesBySmoothFactorsIsCorrected) {
  constexpr int kEdge = 37;  // within a block
  constexpr float kNoise = 0.5f;
  const GuidePlanes guides = MakeWalls(kEdge);
  for (const StageTable* stages : {&kReferenceStages, &kCpuStages}) {
    const ReprojectionTaps taps = FindTaps(*stages, guides, guides, 0);
    double bias = 0;
    const Limited all = RunStage(*stages, {MakeNoise(1.4f, 1, kEdge, kNoise)},
                                 MakeSteadyHistory(kNoise), taps, guides, Limits(1, 4, 8));
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        // The nearest pixels are those of the left wall: its blocks are whole.
        ASSERT_NEAR(all.ratio[0](x, y), x < kEdge ? 1.4 : 1.0, 0.05) << x << " " << y;
        bias += all.bias[0](x, y);
      }
    }
    // What is left is noise.
    EXPECT_LT(bias / (kWidth * kHeight), 1e-3);
  }
}

TEST(LimitHistoryStage, NoiseAloneChangesNothing) {
  const GuidePlanes guides = MakeWalls(0);
  const ReprojectionTaps taps = FindTaps(kCpuStages, guides, guides, 0);
  const Limited all = RunStage(kCpuStages, {MakeNoise(1, 1, 0, 1)}, MakeSteadyHistory(1), taps,
                               guides, Limits(1, 4, 8));
  double sum = 0;
  double bias = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      sum += std::abs(all.ratio[0](x, y) - 1);
      bias += all.bias[0](x, y);
    }
  }
  EXPECT_LT(sum / (kWidth * kHeight), 0.01);
  EXPECT_LT(bias / (kWidth * kHeight), 1e-3);
}

TEST(LimitHistoryStage, ABrightSampleOnAThinPartLeavesMoreHistory) {
  constexpr int kPole = 40;  // two pixels wide
  const GuidePlanes guides =
      MakeWalls([&](int x) { return x == kPole || x == kPole + 1 ? 4.0f : 8.0f; });
  for (const StageTable* stages : {&kReferenceStages, &kCpuStages}) {
    const ReprojectionTaps taps = FindTaps(*stages, guides, guides, 0);
    NewLight light = MakeNoise(1, 1, 0, 0.2f);
    light.colour[0](kPole, kHeight / 2) = 100;
    const Limited all =
        RunStage(*stages, {light}, MakeSteadyHistory(0.2f), taps, guides, Limits(0, 4, 8));
    for (int y = 0; y < kHeight; ++y) {
      // By the moments of the history alone it would be half of this.
      EXPECT_GT(LimitedLength(20, 0.05f, all.bias[0](kPole, y), 8), 0.5) << y;
    }
  }
}

TEST(LimitHistoryStage, ABrightSampleInAVirtualImageLeavesItsHistory) {
  constexpr int kPole = 40;
  const GuidePlanes guides =
      MakeWalls([&](int x) { return x == kPole || x == kPole + 1 ? 4.0f : 8.0f; });
  NewLight light = MakeNoise(1, 1, 0, 0.2f);
  light.colour[0](kPole, kHeight / 2) = 100;
  for (const StageTable* stages : {&kReferenceStages, &kCpuStages}) {
    const ReprojectionTaps taps = FindTaps(*stages, guides, guides, 0);
    const auto length = [&](float roughness) {
      Image1 plane(kWidth, kHeight);
      plane.Fill(roughness);
      const Limited all =
          RunStage(*stages, {light}, MakeSteadyHistory(0.2f), taps, guides, Limits(0, 4, 8), plane);
      return LimitedLength(20, 0.05f, all.bias[0](kPole, kHeight / 2), 8);
    };
    EXPECT_LT(length(1), 2);
    EXPECT_EQ(length(kRoughnessOfImage), 20);
  }
}

TEST(LimitHistoryStage, AChangeOfAThinPartShortensItsHistory) {
  constexpr int kPole = 40;
  const auto on_pole = [](int x) { return x == kPole || x == kPole + 1; };
  const GuidePlanes guides = MakeWalls([&](int x) { return on_pole(x) ? 4.0f : 8.0f; });
  const ReprojectionTaps taps = FindTaps(kCpuStages, guides, guides, 0);
  NewLight light = MakeNoise(1, 1, 0, 0.2f);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = kPole; on_pole(x); ++x) {
      light.colour[0](x, y) *= 3;
    }
  }
  const Limited all =
      RunStage(kCpuStages, {light}, MakeSteadyHistory(0.2f), taps, guides, Limits(0, 4, 8));
  for (int y = 0; y < kHeight; ++y) {
    ASSERT_LT(LimitedLength(20, 0.05f, all.bias[0](kPole, y), 8), 1) << y;
  }
}

TEST(LimitHistoryStage, ANarrowTrailIsFoundWithinFewPixels) {
  // A highlight that has left a stripe of six pixels, three blocks: the neighbourhood of nine
  // blocks shows a third of it.
  constexpr int kLeft = 40;
  const auto in_trail = [](int x) { return x >= kLeft && x < kLeft + 6; };
  const GuidePlanes guides = MakeWalls(0);
  SignalHistory history = MakeSteadyHistory(1);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      if (in_trail(x)) {
        history.mean(x, y) = 1.5f;
        history.variance(x, y) = 2.25f / 3;
        history.compressed(x, y) = ScaledCompressed(history.compressed(x, y), 1.5f);
      }
    }
  }
  LimitHistoryParameters p = Limits(0, 4, 12);
  for (const StageTable* stages : {&kReferenceStages, &kCpuStages}) {
    const ReprojectionTaps taps = FindTaps(*stages, guides, guides, 0);
    const auto length = [&](int fine_signals, auto counts) {
      p.fine_signals = fine_signals;
      const Limited all = RunStage(*stages, {MakeNoise(1, 1, 0, 1)}, history, taps, guides, p);
      double sum = 0;
      int count = 0;
      for (int y = 0; y < kHeight; ++y) {
        for (int x = 0; x < kWidth; ++x) {
          if (counts(x)) {
            sum += static_cast<double>(LimitedLength(20, 0.05f, all.bias[0](x, y), 12));
            ++count;
          }
        }
      }
      return sum / count;
    };
    const auto in_middle = [](int x) { return x >= kLeft + 2 && x < kLeft + 4; };
    const auto far_away = [&](int x) { return std::abs(x - kLeft) > 24; };
    const double coarse = length(0, in_middle);
    EXPECT_GT(coarse, 1);
    EXPECT_LT(length(1, in_middle), 0.5 * coarse);
    EXPECT_GT(length(1, far_away), 0.97 * length(0, far_away));  // noise is no change
  }
}

TEST(LimitHistoryStage, WithoutCorrectionTheChangeShortensTheHistory) {
  const GuidePlanes guides = MakeWalls(0);
  const ReprojectionTaps taps = FindTaps(kCpuStages, guides, guides, 0);
  const Limited all = RunStage(kCpuStages, {MakeNoise(1.5f, 1.5f, 0, 0.2f)},
                               MakeSteadyHistory(0.2f), taps, guides, Limits(0, 4, 8));
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      ASSERT_EQ(all.ratio[0](x, y), 1) << x << " " << y;
      ASSERT_LT(LimitedLength(20, 0.05f, all.bias[0](x, y), 8), 1) << x << " " << y;
    }
  }
}

// Against sums in double precision.
TEST(LimitHistoryStage, TheWideRatioIsTheMeanChangeBeyondItsNoise) {
  const std::vector<double> changes = {0.1, 0.12, 0.08, 0.11, 0.09, 0.1, 0.05, 0.15, 0.1, 0.12};
  const auto known = static_cast<double>(changes.size());
  double mean = 0;
  double square = 0;
  for (const double change : changes) {
    mean += change / known;
    square += change * change / known;
  }
  const double overlap = 27.0 * 27.0 / (13 * 13);
  const double scatter = 3 * (square - mean * mean);
  const auto expected = [&](double noise) {
    return mean * (1 - (overlap * noise / known + 0.003 * 0.003) / (mean * mean));
  };
  const auto ratio = [](double m, double s, double variance, double weights2) {
    return WideRatio(static_cast<float>(m), static_cast<float>(s), static_cast<float>(variance),
                     static_cast<float>(weights2));
  };
  EXPECT_NEAR(ratio(mean, square, 0, 1 / known), std::exp(expected(scatter)), 1e-6);
  EXPECT_NEAR(ratio(-mean, square, 0, 1 / known), std::exp(-expected(scatter)), 1e-6);
  const double variance = 4 * scatter;
  EXPECT_NEAR(ratio(mean, square, variance, 1 / known),
              std::exp(expected(static_cast<double>(kWideNoise) * variance)), 1e-6);
  // Neighbourhoods that disagree, or are noisy; a change of a rounding error's size; too few.
  EXPECT_EQ(ratio(0.1, 0.04, 0, 0.1), 1);
  EXPECT_EQ(ratio(0.1, 0.01, 0.2, 0.1), 1);
  EXPECT_EQ(ratio(0.002, 0.002 * 0.002, 0, 0.04), 1);
  EXPECT_EQ(ratio(0.1, 0.01, 0, 0.12), 1);
  EXPECT_EQ(ratio(0, 0, 0, 0), 1);
  EXPECT_NEAR(ChangeVariance(0.04f, 2), 0.01, 1e-8);
  EXPECT_EQ(ChangeVariance(0.04f, 0), 1);
}

// By hand; blocks without light do not count.
TEST(LimitHistoryStage, MovingLightIsThatOfManyBlocks) {
  constexpr int kColumns = 200;
  constexpr int kRows = 120;
  ComparedPlanes planes(kColumns, kRows);
  planes.valid.Fill(1);
  FilterPlanes averaged(kColumns, kRows, kComparedBorder);
  averaged.colour[1].Fill(1);
  averaged.variance.Fill(0.01f);
  const auto moving_if = [&](int columns, bool is_diffuse) {
    for (int y = 0; y < kRows; ++y) {
      for (int x = 0; x < kColumns; ++x) {
        averaged.colour[0](x, y) = x < columns ? 1.3f : 1.1f;
      }
    }
    return FindMovingLight(averaged, is_diffuse, planes);
  };
  EXPECT_EQ(moving_if(50, true), 0.0f);
  EXPECT_NEAR(moving_if(80, true), 0.5, 1e-5);
  EXPECT_EQ(moving_if(100, true), 1.0f);
  EXPECT_EQ(moving_if(20, false), 0.0f);
  EXPECT_NEAR(moving_if(30, false), 0.5, 1e-5);
  for (int y = 0; y < kRows; ++y) {
    for (int x = 50; x < 100; ++x) {
      planes.valid(x, y) = 0;
    }
  }
  EXPECT_NEAR(moving_if(100, true), (50.0 / 150 - 0.3) / 0.2, 1e-5);
}

// Light that moves loses more of its history to the same change.
TEST(LimitHistoryStage, ChangesCountForMoreWhereLightMoves) {
  ComparedPlanes planes(8, 8);
  planes.valid.Fill(1);
  FilterPlanes blurred(8, 8, kComparedBorder);
  blurred.colour[0].Fill(0.2f);  // difference
  blurred.colour[1].Fill(0.5f);  // variance of single samples
  blurred.variance.Fill(0.01f);  // noise: the square of the difference is four times as large
  const LimitHistoryParameters p = Limits(1, 4, 12);
  MeasureBias(blurred, nullptr, p, &planes);
  EXPECT_EQ(planes.bias(3, 3), 0.0f);
  planes.moving = 1;
  MeasureBias(blurred, nullptr, p, &planes);
  EXPECT_NEAR(planes.bias(3, 3), (0.04 - 1.6 * 0.01) / 0.5, 1e-6);
}

TEST(LimitHistoryStage, TheWideRatioComesBeforeThatOfTheBlock) {
  // What is left of a factor of 1.5 after a wide one of 1.4 is significant, by its noise.
  const double left = 1.5 - 1.4;
  const double share = 1 - 1.75 * 1e-3 / (left * left);
  EXPECT_NEAR(CorrectedRatio(1.5f, 1.0f, 1e-3f, 1.4f, 0), 1.4 * (1 + share * left / 1.4), 1e-5);
  EXPECT_FLOAT_EQ(CorrectedRatio(1.5f, 1.0f, 1.0f, 1.4f, 0), 1.4f);  // noise alone is left
  EXPECT_FLOAT_EQ(CorrectedRatio(1.5f, 1.0f, 1.0f, 1.0f, 0), 1.0f);
}

TEST(LimitHistoryStage, VersionsOfWideChangesAgree) {
  ComparedPlanes planes(37, 21);
  for (int c = 0; c < 2; ++c) {
    planes.work.colour[c] = test::MakePlane(
        37, 21, [&](int x, int y) { return 0.01f + test::RandomAt(x, y, 7 + c); }, kComparedBorder);
  }
  planes.work.colour[0](3, 3) = 0;
  planes.work.colour[1](4, 3) = 0;
  planes.work.colour[0](5, 3) = 1e9f;
  planes.work.variance.Fill(1e-3f);
  planes.compressed.colour[0].Fill(0.4f);
  planes.compressed.colour[1].Fill(0.5f);
  planes.valid = test::MakePlane(
      37, 21, [](int x, int y) { return (x + y) % 5 == 0 ? 0.0f : 1.0f; }, kComparedBorder);
  ComparedPlanes expected = planes;
  reference::MeasureChange(expected.work, &expected);
  EXPECT_EQ(expected.light.colour[0](5, 3), kMostChange);
  const auto correct = [](const StageTable& stages, ComparedPlanes of) {
    of.wide.colour = of.light.colour;  // changes of all sizes
    of.wide.variance.Fill(0.04f);
    stages.correct_history(of.work, Limits(1, 4, 8), &of);
    return of.ratio;
  };
  const Image1 expected_ratio = correct(kReferenceStages, expected);
  test::OnEveryTarget([&] {
    ComparedPlanes found = planes;
    cpu::MeasureChange(found.work, &found);
    for (int c = 0; c < 2; ++c) {
      test::ExpectNear(found.light.colour[c], expected.light.colour[c], 1e-5, 1e-6);
    }
    test::ExpectNear(found.light.variance, expected.light.variance, 0);
    test::ExpectNear(correct(kCpuStages, found), expected_ratio, 1e-4);
  });
}

/// A wall under noisy light, which is multiplied by a factor in every frame.
Frame MakeDimmingWall(int index, float factor) {
  Frame f = test::MakeWall(160, 120, index);
  const float light = std::pow(factor, static_cast<float>(index));
  test::FillImage<3>(&test::Light(&f, SignalKind::kDirectDiffuse), [&](int x, int y, int) {
    return light * (1 + 1.6f * (test::RandomAt(x, y, static_cast<uint32_t>(index)) - 0.5f));
  });
  return f;
}

/// The mean of the picture after many frames, over that of the light.
double Lag(float factor) {
  Settings s = PresetSettings("default").value();
  s.wavelet = Wavelet::kOff;
  Denoiser d = Denoiser::Create(s).value();
  DenoisedFrame out;
  double sum = 0;
  for (int i = 0; i < 40; ++i) {
    EXPECT_TRUE(d.Denoise(MakeDimmingWall(i, factor), &out).ok());
    // Of the last frames: the mean of one varies by a tenth of a percent.
    const auto light = std::pow(static_cast<double>(factor), i);
    sum += i >= 32 ? test::MeanOf(out.colour) / light / 8 : 0.0;
  }
  return sum;
}

// By less per frame than the noise of the neighbourhoods of correct_history.
TEST(LimitHistoryStage, SlowChangesOfAllLightAreFollowed) {
  EXPECT_NEAR(Lag(1), 1, 0.002);
  EXPECT_NEAR(Lag(0.995f), 1, 0.008);
  EXPECT_NEAR(Lag(1.005f), 1, 0.008);
}

/// The planes before correct_history of a history that rises by dx and dy per block.
ComparedPlanes MakeSlope(float dx, float dy) {
  constexpr int kBlocks = 12;
  ComparedPlanes planes(kBlocks, kBlocks);
  for (int y = 0; y < kBlocks; ++y) {
    for (int x = 0; x < kBlocks; ++x) {
      const float c = 0.2f + dx * static_cast<float>(x) + dy * static_cast<float>(y);
      planes.compressed.colour[0](x, y) = planes.compressed.colour[1](x, y) = c;
      planes.compressed.variance(x, y) = 1e-4f;
      planes.valid(x, y) = 1;
    }
  }
  return planes;
}

/// What correct_history makes of the difference and its noise.
ComparedPlanes Jittered(const StageTable& stages, ComparedPlanes planes, float jitter_x,
                        float jitter_y) {
  LimitHistoryParameters p = Limits(0, 0, 0, jitter_x);
  p.jitter_y = jitter_y;
  stages.correct_history(planes.light, p, &planes);
  return planes;
}

void ExpectJitterToMoveTheDifference(const StageTable& stages) {
  const ComparedPlanes slope = MakeSlope(0.03f, -0.01f);
  const auto expect = [&](const ComparedPlanes& planes, int x, int y, double shift, double noise) {
    const ComparedPlanes got = Jittered(stages, planes, 0.25f, -0.5f);
    EXPECT_NEAR(got.light.colour[0](x, y),
                planes.compressed.colour[0](x, y) - planes.compressed.colour[1](x, y) - shift, 1e-6)
        << x << " " << y;
    EXPECT_NEAR(got.light.variance(x, y), 1e-4 + 1.6 * noise, 1e-7) << x << " " << y;
  };
  // Slopes per pixel: 0.015 and -0.005; 1.6 of their squares count as noise.
  expect(slope, 5, 5, 0.25 * 0.015 + 0.5 * 0.005, 0.015 * 0.015 + 0.005 * 0.005);
  expect(MakeSlope(0, 0), 5, 5, 0, 0);
  // Half of an edge is no slope, nor is what lies outside or has no history.
  ComparedPlanes edge = MakeSlope(0, 0);
  ComparedPlanes hole = slope;
  for (int y = 0; y < 12; ++y) {
    for (int x = 6; x < 12; ++x) {
      edge.compressed.colour[1](x, y) += 0.5f;
      hole.valid(x, y) = 0;
      hole.compressed.colour[1](x, y) = kNan;
    }
  }
  expect(edge, 5, 5, 0, 0);
  expect(edge, 6, 5, 0, 0);
  expect(hole, 5, 5, 0.5 * 0.005, 0.005 * 0.005);
  expect(slope, 0, 5, 0.5 * 0.005, 0.005 * 0.005);
  EXPECT_EQ(Jittered(stages, slope, 0, 0).light.variance(5, 5), 1e-4f);
  EXPECT_EQ(Jittered(stages, hole, 0.25f, 0).light.variance(8, 5), 1e-4f);
}

TEST(LimitHistoryStage, JitterMovesTheExpectedDifference) {
  ExpectJitterToMoveTheDifference(kReferenceStages);
  for (const int64_t target : hwy::SupportedAndGeneratedTargets()) {
    hwy::SetSupportedTargetsForTest(target);
    SCOPED_TRACE(hwy::TargetName(target));
    ExpectJitterToMoveTheDifference(kCpuStages);
  }
  hwy::SetSupportedTargetsForTest(0);
}

/// Light that rises along x, as rays beside the centres of the pixels by `offset` see it.
NewLight MakeRising(float offset, float factor) {
  NewLight light = MakeNoise(1, 1, 0, 0.02f);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      light.colour[0](x, y) *= factor * std::exp(0.05f * (static_cast<float>(x) + offset - 40));
    }
  }
  return light;
}

TEST(LimitHistoryStage, WhatJitterMovesIsNoChangeOfTheLight) {
  const GuidePlanes guides = MakeWalls(0);
  const ReprojectionTaps taps = FindTaps(kCpuStages, guides, guides, 0);
  SignalHistory history = MakeSteadyHistory(0.02f);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const float l = std::exp(0.05f * (static_cast<float>(x) - 40));
      history.mean(x, y) = l;
      history.variance(x, y) = l * l * 0.02f * 0.02f / 3;
      history.compressed(x, y) = l / (1 + l);
    }
  }
  const auto length = [&](float offset, float factor, float jitter) {
    const Limited all = RunStage(kCpuStages, {MakeRising(offset, factor)}, history, taps, guides,
                                 Limits(0, 4, 8, jitter));
    return LimitedLength(20, 0.05f, all.bias[0](40, kHeight / 2), 8);
  };
  EXPECT_LT(length(0.5f, 1, 0), 10);
  EXPECT_EQ(length(0.5f, 1, 0.5f), 20);
  EXPECT_EQ(length(-0.5f, 1, -0.5f), 20);
  EXPECT_EQ(length(0, 1, 0), 20);
  EXPECT_LT(length(0.5f, 1, -0.5f), 10);
  EXPECT_LT(length(0.5f, 1.25f, 0.5f), 5);
}

}  // namespace
}  // namespace stillray::limit_history_test
