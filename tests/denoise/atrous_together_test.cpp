// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Levels of the wavelet that make their own stops, or run two at a time, must leave the very bits
// of one stage and one level after the other.
#include <cmath>
#include <vector>

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include "core/cache_size.h"
#include "denoise/stages/atrous.h"
#include "every_target.h"
#include "make_denoiser.h"
#include "stage_planes.h"
#include "test_frames.h"

namespace stillray {
namespace {

using test::DifferentBits;
using test::kHeight;
using test::kWidth;
using test::OnEveryTarget;

/// One signal before a level; its pixels have light where there is a surface, or (not `complete`)
/// only on some of those.
struct LevelInput {
  GuidePlanes guides = test::MakeGuides(true);
  FilterPlanes planes{kWidth, kHeight, 16};
  Image1 present{kWidth, kHeight, 16};
  Image1 length{kWidth, kHeight, 16};
  bool complete;

  explicit LevelInput(bool is_complete, uint32_t seed = 100) : complete(is_complete) {
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        const bool lit = complete || test::Random(x, y, seed) < 0.6f;
        present(x, y) = lit && guides.inverse_depth(x, y) > 0 ? 1.0f : 0.0f;
        length(x, y) = std::floor(8 * test::Random(x, y, seed + 1));
        planes.variance(x, y) = test::Random(x, y, seed + 2);
        for (int c = 0; c < 3; ++c) {
          planes.colour[c](x, y) = 2 * test::Random(x, y, seed + 3 + static_cast<uint32_t>(c));
        }
      }
    }
  }
  AtrousSignal Signal(const Image1* stop, FilterPlanes* out) const {
    AtrousSignal signal = {&planes.colour, &planes.variance, out, stop, &present};
    signal.complete = complete;
    signal.length = &length;
    return signal;
  }
};

int DifferentBitsOf(const FilterPlanes& a, const FilterPlanes& b) {
  return DifferentBits(a.variance, b.variance) + DifferentBits(a.colour, b.colour);
}

/// A level that is given its stops, and one that makes them.
void CheckStopsOnTheWay(const LevelInput& in, const AtrousParameters& p) {
  const auto apart_and_together = [&](const auto& prefilter, const auto& atrous) {
    FilterPlanes apart(kWidth, kHeight, 16);
    Image1 stop(kWidth, kHeight, 16);
    AtrousSignal signal = in.Signal(&stop, &apart);
    prefilter(PrefilterInputOf(signal, in.guides), p.prefilter, &stop);
    atrous({&signal, 1}, in.guides, p);
    FilterPlanes together(kWidth, kHeight, 16);
    signal = in.Signal(nullptr, &together);
    atrous({&signal, 1}, in.guides, p);
    EXPECT_EQ(DifferentBitsOf(together, apart), 0);
    EXPECT_GT(DifferentBitsOf(together, in.planes), kWidth * kHeight / 2);
  };
  apart_and_together(reference::PrefilterVariance, reference::Atrous);
  OnEveryTarget([&] { apart_and_together(cpu::PrefilterVariance, cpu::Atrous); });
}

TEST(AtrousTogether, StopsOnTheWay) {
  AtrousParameters p;
  for (const bool complete : {true, false}) {
    const LevelInput in(complete);
    for (const int radius : {1, 2}) {
      for (const int step : {1, 2, 8}) {
        p.radius = radius;
        p.step = step;
        p.edges.plane = step == 2;
        p.prefilter.smooth = step != 8;
        p.prefilter.unbounded_below = step == 1 ? 3.0f : 0.0f;
        CheckStopsOnTheWay(in, p);
      }
    }
  }
}

AtrousParameters LevelOf(int radius, int step) {
  AtrousParameters p;
  p.radius = radius;
  p.step = step;
  return p;
}

/// Two signals, of which one keeps what lies between the levels.
void CheckPair(const AtrousParameters& first, const AtrousParameters& second) {
  const LevelInput in[2] = {LevelInput(true), LevelInput(true, 200)};
  const auto together_and_apart = [&](const auto& pair, const auto& level) {
    std::vector<FilterPlanes> between(2, FilterPlanes(kWidth, kHeight, 16));
    std::vector<FilterPlanes> apart = between;
    std::vector<FilterPlanes> together = between;
    Image3 kept(kWidth, kHeight, 16);
    std::vector<AtrousSignal> signals;
    for (size_t i = 0; i < 2; ++i) {
      signals.push_back(in[i].Signal(nullptr, &between[i]));
    }
    level(signals, in[0].guides, first);
    for (size_t i = 0; i < 2; ++i) {
      signals[i].colour = &between[i].colour;
      signals[i].variance = &between[i].variance;
      signals[i].out = &apart[i];
    }
    level(signals, in[0].guides, second);
    for (size_t i = 0; i < 2; ++i) {
      signals[i] = in[i].Signal(nullptr, &together[i]);
    }
    signals[1].kept = &kept;
    pair(signals, in[0].guides, first, second);
    for (size_t i = 0; i < 2; ++i) {
      EXPECT_EQ(DifferentBitsOf(together[i], apart[i]), 0) << "signal " << i;
      EXPECT_GT(DifferentBitsOf(together[i], between[i]), kWidth * kHeight / 2);
    }
    EXPECT_EQ(DifferentBits(kept, between[1].colour), 0);
  };
  together_and_apart(reference::AtrousPair, reference::Atrous);
  OnEveryTarget([&] { together_and_apart(cpu::AtrousPair, cpu::Atrous); });
}

TEST(AtrousTogether, Pair) {
  for (const int radius : {1, 2}) {
    for (const auto& [first, second] : {std::pair{1, 2}, {2, 1}, {1, 1}, {4, 8}, {8, 4}}) {
      SCOPED_TRACE(testing::Message()
                   << "radius " << radius << ", steps " << first << " and " << second);
      AtrousParameters p[2] = {LevelOf(radius, first), LevelOf(radius, second)};
      for (AtrousParameters& level : p) {
        level.edges.plane = first == 2;
        level.prefilter.smooth = second != 1;
      }
      CheckPair(p[0], p[1]);
    }
  }
}

TEST(AtrousTogether, PairPaysWhereItFitsTheCacheAndTheThreads) {
  const GuidePlanes low(64, 40, 32);
  const GuidePlanes high(1280, 720, 32);
  const std::vector<AtrousSignal> one(1);
  tbb::task_arena single(1);
  single.execute([&] {
    EXPECT_TRUE(cpu::PairPays(one, low, LevelOf(1, 1), LevelOf(1, 2)));
    EXPECT_FALSE(cpu::PairPays(one, low, LevelOf(1, 4), LevelOf(1, 8)));  // bands of 128 rows
    EXPECT_FALSE(cpu::PairPays(one, high, LevelOf(2, 1), LevelOf(2, 2)));
    // Rings of 17 rows and guides of 25, more for each signal.
    const size_t row = sizeof(float) * static_cast<size_t>(high.id.stride());
    for (size_t count = 1; count <= 8; ++count) {
      const std::vector<AtrousSignal> signals(count);
      EXPECT_EQ(cpu::PairPays(signals, high, LevelOf(1, 4), LevelOf(1, 8)),
                row * (25 * 6 + 17 * 4 * count) <= SecondCacheBytes());
    }
  });
  tbb::task_arena many(64);
  many.execute([&] { EXPECT_FALSE(cpu::PairPays(one, high, LevelOf(1, 1), LevelOf(1, 2))); });
}

/// A lit wall of 40x200 pixels, every one with its own light.
Frame MakeNoisyWall(int i) {
  Frame f = test::MakeWall(40, 200, i);
  for (Signal& s : f.signals) {
    test::FillImage<3>(&s.radiance, [&](int x, int y, int c) {
      return 2 * test::Random(x, y, static_cast<uint32_t>(16 * i + c));
    });
  }
  return f;
}

/// Pictures of a few frames on arenas in which all levels but the last run in pairs, the first two,
/// and none.
void CheckBandsAndPairs(const Settings& s) {
  std::vector<Image3> expected;
  for (const int threads : {1, 2, 16}) {
    tbb::task_arena(threads).execute([&] {
      Denoiser d = test::MakeDenoiser(s);
      for (int i = 0; i < 5; ++i) {
        DenoisedFrame out;
        ASSERT_TRUE(d.Denoise(MakeNoisyWall(i), &out).ok());
        if (threads == 1) {
          expected.push_back(out.colour);
        }
        EXPECT_TRUE(test::SameBits(out.colour, expected[static_cast<size_t>(i)]))
            << threads << " threads, frame " << i;
      }
    });
  }
}

TEST(AtrousTogether, BandsAndPairsDoNotChangeThePicture) {
  for (const char* preset : {"svgf", "psvgf"}) {
    for (const int feedback : {0, 1, 2, 3, 4, 5}) {  // after the first or second level of a pair
      SCOPED_TRACE(testing::Message() << preset << ", feedback " << feedback);
      Settings s = PresetSettings(preset).value();
      s.kernel = Kernel::k3x3;
      s.feedback = feedback;
      CheckBandsAndPairs(s);
    }
  }
}

}  // namespace
}  // namespace stillray
