// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/stages/reproject.h"

#include <algorithm>
#include <limits>

#include <gtest/gtest.h>

#include "stage_test.h"

namespace stillray::reproject_test {
namespace {

constexpr int kBorder = 4;
const ReprojectParameters kParameters = {0.05f, 0.9f, 1, 1, 0};

struct Version {
  decltype(&cpu::FindTaps) find_taps;
  decltype(&cpu::FetchHistory) fetch_history;
};
constexpr Version kVersions[] = {{&reference::FindTaps, &reference::FetchHistory},
                                 {&cpu::FindTaps, &cpu::FetchHistory}};

/// A wall that faces the camera, of one id.
GuidePlanes MakeWall(int width, int height) {
  GuidePlanes guides(width, height, kBorder);
  guides.inverse_depth.Fill(0.25f);
  guides.depth.Fill(4);
  guides.normal[2].Fill(1);
  guides.id.Fill(1);
  return guides;
}

Image2 Constant(int width, int height, float x, float y) {
  Image2 motion(width, height);
  motion[0].Fill(x);
  motion[1].Fill(y);
  return motion;
}

/// A history of one sample everywhere.
SignalHistory MakeHistory(int width, int height, const std::function<float(int, int)>& luminance) {
  SignalHistory history(width, height);
  history.colour[0] = test::MakePlane(width, height, luminance);
  history.mean = test::MakePlane(width, height, luminance, SignalHistory::kBorder);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      history.length(x, y) = 1;
    }
  }
  return history;
}

/// Taps, and the history that they fetch.
struct Fetched {
  ReprojectionTaps taps;
  SignalHistory history;

  Fetched(const Version& version, const GuidePlanes& now, const GuidePlanes& before,
          const Image2& motion, const SignalHistory& history_before,
          const ReprojectParameters& p = kParameters)
      : taps(motion.width(), motion.height()), history(motion.width(), motion.height()) {
    version.find_taps(now, before, motion, p, &taps);
    version.fetch_history(history_before, taps, &history);
  }
  float At(int x, int y) const { return history.colour[0](x, y); }
};

TEST(Reproject, BilinearTapsAlongTheMotion) {
  const GuidePlanes wall = MakeWall(19, 7);
  const SignalHistory ramp = MakeHistory(
      19, 7, [](int x, int y) { return 10 + static_cast<float>(x) + 100 * static_cast<float>(y); });
  const Image2 motion = Constant(19, 7, 0.25f, -0.5f);
  for (const Version& version : kVersions) {
    const Fetched fetched(version, wall, wall, motion, ramp);
    for (int y = 1; y < 7; ++y) {
      for (int x = 0; x < 18; ++x) {
        EXPECT_NEAR(fetched.At(x, y),
                    10.25 + static_cast<double>(x) + 100 * (static_cast<double>(y) - 0.5), 1e-3);
        EXPECT_FLOAT_EQ(fetched.history.length(x, y), 1);
      }
    }
    const float expected[4] = {0.375f, 0.125f, 0.375f, 0.125f};
    for (int i = 0; i < 4; ++i) {
      EXPECT_FLOAT_EQ(fetched.taps.weight[i](5, 3), expected[i]);
    }
  }
}

TEST(Reproject, TheNearestTapAlone) {
  const GuidePlanes wall = MakeWall(19, 7);
  const SignalHistory ramp = MakeHistory(
      19, 7, [](int x, int y) { return 10 + static_cast<float>(x) + 100 * static_cast<float>(y); });
  ReprojectParameters p = kParameters;
  p.history_taps_nearest = 1;
  for (const Version& version : kVersions) {
    const Fetched away(version, wall, wall, Constant(19, 7, 1.6f, -0.8f), ramp, p);
    const Fetched at_home(version, wall, wall, Constant(19, 7, 0.4f, -0.5f), ramp, p);
    for (int y = 1; y < 7; ++y) {
      for (int x = 0; x < 17; ++x) {
        EXPECT_EQ(away.At(x, y), ramp.colour[0](x + 2, y - 1));
        EXPECT_EQ(at_home.At(x, y), ramp.colour[0](x, y));  // -0.5 + 0.5 is its own row
      }
    }
    EXPECT_FALSE(away.taps.HasHistory(18, 3));  // outside
    EXPECT_TRUE(at_home.taps.HasHistory(18, 3));
  }
}

TEST(Reproject, TheNearestTapIsTestedAtItsOwnPlace) {
  // On a slope that the motion does not follow, a history is as far off as the place is, not as the
  // pixel: 1.6 pixels and not 2 under a tolerance of 1.7, 2.4 and not 2 under one of 2.2.
  GuidePlanes slope = MakeWall(19, 7);
  for (int y = 0; y < 7; ++y) {
    for (int x = 0; x < 19; ++x) {
      slope.inverse_depth(x, y) = 0.25f + 0.02f * static_cast<float>(x);
      slope.gradient[0](x, y) = 0.02f;
    }
  }
  const SignalHistory ones = MakeHistory(19, 7, [](int, int) { return 1.0f; });
  ReprojectParameters p = kParameters;
  p.history_taps_nearest = 1;
  p.history_search = 0;
  for (const Version& version : kVersions) {
    p.history_depth = 0.0093f;  // of 0.43, and 1.5 pixels of slack
    EXPECT_TRUE(
        Fetched(version, slope, slope, Constant(19, 7, -1.6f, 0), ones, p).taps.HasHistory(9, 3));
    p.history_depth = 0.0325f;
    EXPECT_FALSE(
        Fetched(version, slope, slope, Constant(19, 7, -2.4f, 0), ones, p).taps.HasHistory(9, 3));
  }
}

TEST(Reproject, AtTheEdgeOfThePictureTheTapsInsideCount) {
  const GuidePlanes wall = MakeWall(19, 7);
  const SignalHistory ramp =
      MakeHistory(19, 7, [](int x, int) { return static_cast<float>(x) + 1; });
  const Image2 motion = Constant(19, 7, 0.5f, 0);
  for (const Version& version : kVersions) {
    const Fetched fetched(version, wall, wall, motion, ramp);
    EXPECT_FLOAT_EQ(fetched.At(17, 3), 18.5f);
    EXPECT_FLOAT_EQ(fetched.At(18, 3), 19);
  }
}

TEST(Reproject, OutsideOfThePictureThereIsNoHistory) {
  const GuidePlanes wall = MakeWall(19, 7);
  const SignalHistory ones = MakeHistory(19, 7, [](int, int) { return 1.0f; });
  for (const float motion : {-30.0f, 30.0f, 1e30f, std::numeric_limits<float>::quiet_NaN(),
                             std::numeric_limits<float>::infinity()}) {
    for (const Version& version : kVersions) {
      const Fetched fetched(version, wall, wall, Constant(19, 7, motion, 0), ones);
      EXPECT_FALSE(fetched.taps.HasHistory(9, 3)) << motion;
      EXPECT_EQ(fetched.At(9, 3), 0) << motion;
      EXPECT_EQ(fetched.history.length(9, 3), 0) << motion;
    }
  }
}

/// Left of column 8 a wall with light 1, right of it another surface with light 1000.
void ExpectNoLeak(const GuidePlanes& guides, const ReprojectParameters& p) {
  const SignalHistory history =
      MakeHistory(19, 7, [](int x, int) { return x < 8 ? 1.0f : 1000.0f; });
  for (const float motion : {0.5f, -0.5f, 0.9f}) {
    for (const Version& version : kVersions) {
      const Fetched fetched(version, guides, guides, Constant(19, 7, motion, 0), history, p);
      for (int x = 0; x < 19; ++x) {
        EXPECT_FLOAT_EQ(fetched.At(x, 3), x < 8 ? 1.0f : 1000.0f) << x << " " << motion;
      }
    }
  }
}

TEST(Reproject, NothingLeaksBetweenIds) {
  GuidePlanes guides = MakeWall(19, 7);
  for (int y = 0; y < 7; ++y) {
    std::fill(guides.id.Row(y) + 8, guides.id.Row(y) + 19, 2u);
  }
  ExpectNoLeak(guides, kParameters);
}

TEST(Reproject, NothingLeaksBetweenDepths) {
  GuidePlanes guides = MakeWall(19, 7);
  for (int y = 0; y < 7; ++y) {
    std::fill(guides.inverse_depth.Row(y) + 8, guides.inverse_depth.Row(y) + 19, 0.2f);
  }
  ExpectNoLeak(guides, {0.05f, 0.9f, 0, 1, 0});
}

TEST(Reproject, NothingLeaksBetweenNormals) {
  GuidePlanes guides = MakeWall(19, 7);
  for (int y = 0; y < 7; ++y) {
    std::fill(guides.normal[2].Row(y) + 8, guides.normal[2].Row(y) + 19, 0.6f);
    std::fill(guides.normal[0].Row(y) + 8, guides.normal[0].Row(y) + 19, 0.8f);
  }
  ExpectNoLeak(guides, {0.05f, 0.9f, 0, 1, 0});
}

TEST(Reproject, SearchAveragesThe3x3Taps) {
  const GuidePlanes now = MakeWall(19, 7);
  GuidePlanes before = MakeWall(19, 7);
  before.id.Fill(2);
  before.id(10, 2) = before.id(8, 4) = 1;
  SignalHistory history = MakeHistory(19, 7, [](int, int) { return 1000.0f; });
  history.colour[0](10, 2) = 3;
  history.colour[0](8, 4) = 5;
  const Image2 still = Constant(19, 7, 0, 0);
  for (const Version& version : kVersions) {
    const Fetched fetched(version, now, before, still, history);
    EXPECT_FLOAT_EQ(fetched.At(9, 3), 4);  // both
    EXPECT_FLOAT_EQ(fetched.At(11, 3), 3);
    EXPECT_FALSE(fetched.taps.HasHistory(13, 3));
    const Fetched without(version, now, before, still, history, {0.05f, 0.9f, 1, 0, 0});
    EXPECT_FALSE(without.taps.HasHistory(9, 3));
    EXPECT_EQ(without.At(9, 3), 0);
    EXPECT_FLOAT_EQ(without.At(10, 2), 3);
  }
}

TEST(Reproject, TapsWithoutLightCountForTheLengthAlone) {
  const GuidePlanes wall = MakeWall(19, 7);
  SignalHistory history = MakeHistory(19, 7, [](int, int) { return 8.0f; });
  for (int y = 0; y < 7; ++y) {
    history.length(9, y) = history.colour[0](9, y) = 0;
  }
  const Image2 motion = Constant(19, 7, 0.25f, 0);
  for (const Version& version : kVersions) {
    const Fetched fetched(version, wall, wall, motion, history);
    EXPECT_FLOAT_EQ(fetched.At(8, 3), 8);
    EXPECT_FLOAT_EQ(fetched.history.length(8, 3), 0.75f);
  }
}

TEST(Reproject, VectorsMatchTheReference) {
  test::ForSizesAndTargets([](int width, int height) {
    GuidePlanes now = MakeWall(width, height);
    GuidePlanes before = MakeWall(width, height);
    Image2 motion(width, height);
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        now.id(x, y) = static_cast<uint32_t>(4 * test::RandomAt(x / 7, y / 3, 1));
        before.id(x, y) = static_cast<uint32_t>(4 * test::RandomAt((x + 1) / 7, y / 3, 1));
        now.inverse_depth(x, y) = test::RandomAt(x, y, 2) < 0.1f ? 0.0f : 0.25f;
        before.inverse_depth(x, y) = test::RandomAt(x, y, 3) < 0.1f ? 0.5f : 0.25f;
        const bool still = y % 4 == 3;
        motion[0](x, y) = still ? 0.0f : 1.3f + 0.5f * test::RandomAt(x / 5, y, 4);
        motion[1](x, y) = still ? 0.0f : 3 * test::RandomAt(x, y / 6, 5) - 1.5f;
      }
    }
    const SignalHistory history =
        MakeHistory(width, height, [](int x, int y) { return 1 + 4 * test::RandomAt(x, y, 6); });
    for (const int search : {0, 1}) {
      const ReprojectParameters p = {0.05f, 0.9f, 1, search, 0};
      const Fetched expected(kVersions[0], now, before, motion, history, p);
      const Fetched got(kVersions[1], now, before, motion, history, p);
      test::ExpectNear(got.history.colour[0], expected.history.colour[0], 2e-6);
      test::ExpectNear(got.history.mean, expected.history.mean, 2e-6);
      test::ExpectNear(got.history.length, expected.history.length, 2e-6);
      for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
          ASSERT_EQ(got.taps.HasHistory(x, y), expected.taps.HasHistory(x, y)) << x << " " << y;
        }
      }
    }
  });
}

}  // namespace
}  // namespace stillray::reproject_test
