// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#include "render/vulkan/submission_pace.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace stillray::render {
namespace {

constexpr double kMost = 1e9;

// The time of `paths` on a device that traces a million in this many milliseconds.
double TimeOf(double paths, double ms_per_million) {
  return paths * ms_per_million / 1e6;
}

TEST(SubmissionPaceTest, GrowsFromFewPathsToTheTarget) {
  SubmissionPace pace(200);
  EXPECT_EQ(pace.paths(), 1 << 14);
  double before = 0;
  for (int i = 0; i < 30; ++i) {
    const double paths = pace.paths();
    EXPECT_LE(paths, 2 * std::max<double>(before, 1 << 13));
    EXPECT_LE(TimeOf(paths, 100), 201);  // never above the target
    pace.Adapt(paths, TimeOf(paths, 100), kMost);
    before = paths;
  }
  EXPECT_NEAR(pace.paths(), 2e6, 1);
}

TEST(SubmissionPaceTest, ShrinksAtOnceWhereWorkTakesLonger) {
  SubmissionPace pace(200);
  for (int i = 0; i < 10; ++i) {
    pace.Adapt(pace.paths(), 1, kMost);
  }
  const double paths = pace.paths();
  pace.Adapt(paths, 400, kMost);
  EXPECT_NEAR(pace.paths(), paths / 2, 1);
  for (int i = 0; i < 30; ++i) {
    pace.Adapt(pace.paths(), 1e6, kMost);
  }
  EXPECT_EQ(pace.paths(), 1 << 11);
}

TEST(SubmissionPaceTest, AFrameOfHalfTheTargetIsOneSubmission) {
  constexpr double kFrame = 2e6;
  SubmissionPace pace(200);
  int submissions = 0;
  for (double done = 0; done < kFrame; ++submissions) {
    const double paths = std::min(pace.paths(), kFrame - done);
    pace.Adapt(paths, TimeOf(paths, 40), kMost);
    done += paths;
  }
  EXPECT_LE(submissions, 8);
  for (int frame = 0; frame < 3; ++frame) {
    pace.Adapt(kFrame / 4, TimeOf(kFrame / 4, 40), kMost);  // its last part was small
    EXPECT_GE(pace.paths(), kFrame / 2);
    pace.Adapt(kFrame, TimeOf(kFrame, 40), kMost);
    EXPECT_GE(pace.paths(), kFrame);
    EXPECT_FALSE(pace.IsEnough(kFrame));
    EXPECT_TRUE(pace.IsEnough(pace.paths()));
  }
}

TEST(SubmissionPaceTest, NeverAboveTheMost) {
  SubmissionPace pace(200);
  for (int i = 0; i < 5; ++i) {
    pace.Adapt(pace.paths(), 1, 5000);
    EXPECT_EQ(pace.paths(), 5000);
  }
}

TEST(StepForecastTest, FollowsTheLongestPathsOfTheLastFrame) {
  StepForecast forecast;
  EXPECT_EQ(forecast.Planned(30), 30);  // nothing is known
  forecast.Used(9);
  forecast.Used(7);
  EXPECT_EQ(forecast.Planned(30), 11);
  EXPECT_EQ(forecast.Planned(10), 10);
  forecast.NextFrame();
  EXPECT_EQ(forecast.Planned(30), 11);
  forecast.Used(5);
  EXPECT_EQ(forecast.Planned(30), 11);  // another part of this frame may be like the last frame
  forecast.Used(20);
  EXPECT_EQ(forecast.Planned(30), 22);
  forecast.NextFrame();
  forecast.NextFrame();
  EXPECT_EQ(forecast.Planned(30), 30);  // a frame without paths has no longest one
}

TEST(StepForecastTest, AFrameOfSkyHasNoSteps) {
  StepForecast forecast;
  forecast.Used(0);
  forecast.NextFrame();
  EXPECT_EQ(forecast.Planned(30), 2);
}

}  // namespace
}  // namespace stillray::render
