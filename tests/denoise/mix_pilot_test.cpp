// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/stages/mix_pilot.h"

#include <gtest/gtest.h>

#include "stage_test.h"

namespace stillray::mix_pilot_test {
namespace {

using test::MakePlane;
using test::RandomPlane;

TEST(MixPilot, LongerHistoriesKeepMoreOfTheirOwnLight) {
  EXPECT_EQ(PilotShare(1, 4), 1);
  EXPECT_EQ(PilotShare(4, 4), 1);
  EXPECT_EQ(PilotShare(16, 4), 0.25f);
  EXPECT_EQ(PilotShare(0, 4), 1);  // nothing of its own
  // A quarter of the way from deviation 2 to deviation 1.
  EXPECT_FLOAT_EQ(PilotVariance(4, 1, 0.25f), 1.75f * 1.75f);
  const auto mix = {&reference::MixPilot, &cpu::MixPilot};
  for (const auto& version : mix) {
    const Image1 own = MakePlane(9, 1, [](int, int) { return 8.0f; });
    const Image1 own_variance = MakePlane(9, 1, [](int, int) { return 4.0f; });
    const Image1 length = MakePlane(9, 1, [](int x, int) { return x == 0 ? 2.0f : 16.0f; });
    Image1 mean = MakePlane(9, 1, [](int, int) { return 4.0f; });
    Image1 variance = MakePlane(9, 1, [](int, int) { return 1.0f; });
    version({&own, &own_variance, &length}, 4, &mean, &variance);
    EXPECT_NEAR(mean(0, 0), 4, 1e-6);
    EXPECT_NEAR(variance(0, 0), 1, 1e-6);
    EXPECT_NEAR(mean(8, 0), 7, 1e-6);
    EXPECT_NEAR(variance(8, 0), 1.75 * 1.75, 1e-5);
  }
}

TEST(MixPilot, VersionsAgree) {
  test::ForSizesAndTargets([](int width, int height) {
    const Image1 own = RandomPlane(width, height, 1, 4);
    const Image1 own_variance = RandomPlane(width, height, 2, 4);
    const Image1 length = RandomPlane(width, height, 3, 20);
    Image1 expected = RandomPlane(width, height, 4, 4);
    Image1 expected_variance = RandomPlane(width, height, 5, 4);
    Image1 got = expected;
    Image1 got_variance = expected_variance;
    const MixPilotInput in = {&own, &own_variance, &length};
    reference::MixPilot(in, 4, &expected, &expected_variance);
    cpu::MixPilot(in, 4, &got, &got_variance);
    test::ExpectNear(got, expected, 1e-5);
    test::ExpectNear(got_variance, expected_variance, 1e-5);
  });
}

}  // namespace
}  // namespace stillray::mix_pilot_test
