// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "render/pixel_order.h"

#include <algorithm>
#include <cmath>
#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/random.h"

namespace stillray::render::pixel_order_test {
namespace {

constexpr int kSide = 192;
constexpr Tile kSquare = {0, 0, kSide, kSide};

std::vector<PixelPosition> PixelsOf(int cycle, int64_t frame, uint64_t seed = 0) {
  std::vector<PixelPosition> pixels;
  PixelOrder(cycle, seed, frame).Collect(kSquare, &pixels);
  return pixels;
}

// Pixels of `count` frames from `first` on, one after the other.
std::vector<PixelPosition> PixelsOfFrames(int cycle, int64_t first, int count) {
  std::vector<PixelPosition> all;
  for (int f = 0; f < count; ++f) {
    const std::vector<PixelPosition> some = PixelsOf(cycle, first + f);
    all.insert(all.end(), some.begin(), some.end());
  }
  return all;
}

std::vector<PixelPosition> RandomPixels(size_t count) {
  std::set<std::pair<int, int>> taken;
  for (uint32_t i = 0; taken.size() < count; ++i) {
    const uint32_t h = HashU32(i + 1);
    taken.insert(
        {static_cast<int>((h & 0xffff) * kSide >> 16), static_cast<int>((h >> 16) * kSide >> 16)});
  }
  std::vector<PixelPosition> pixels;
  for (const auto& [x, y] : taken) {
    pixels.push_back({x, y});
  }
  return pixels;
}

// How far apart pixels are, in units of the mean spacing: 1 would be a square grid.
struct Spread {
  double nearest = 0;      // mean distance to the nearest other pixel
  double largest_gap = 0;  // largest distance of any place to the nearest pixel
  double unevenness = 0;   // variance of counts in boxes over their mean; 1: Poisson
};

Spread MeasureSpread(const std::vector<PixelPosition>& pixels) {
  constexpr int kMargin = 32;
  const double spacing = kSide / std::sqrt(static_cast<double>(pixels.size()));
  std::vector<uint8_t> set(kSide * kSide);
  for (const PixelPosition& p : pixels) {
    set[static_cast<size_t>(p.y * kSide + p.x)] = 1;
  }
  const auto nearest = [&](int x, int y, bool self) {
    for (int reach = 2; reach <= kMargin; reach *= 2) {
      int best = reach * reach + 1;
      for (int dy = -reach; dy <= reach; ++dy) {
        for (int dx = -reach; dx <= reach; ++dx) {
          if (set[static_cast<size_t>((y + dy) * kSide + x + dx)] != 0 &&
              (self || dx != 0 || dy != 0)) {
            best = std::min(best, dx * dx + dy * dy);
          }
        }
      }
      if (best <= reach * reach) {
        return std::sqrt(static_cast<double>(best));
      }
    }
    return 1e3;
  };
  Spread spread;
  int inner = 0;
  for (int y = kMargin; y < kSide - kMargin; y += 3) {
    for (int x = kMargin; x < kSide - kMargin; ++x) {
      if (set[static_cast<size_t>(y * kSide + x)] != 0) {
        spread.nearest += nearest(x, y, false) / spacing;
        ++inner;
      } else if (x % 3 == 0) {
        spread.largest_gap = std::max(spread.largest_gap, nearest(x, y, true) / spacing);
      }
    }
  }
  spread.nearest /= inner;
  const int box = std::max(4, static_cast<int>(std::lround(4 * spacing)));
  double sum = 0;
  double squares = 0;
  int boxes = 0;
  for (int y = 0; y + box <= kSide; y += box / 2) {
    for (int x = 0; x + box <= kSide; x += box / 2) {
      int count = 0;
      for (int i = 0; i < box * box; ++i) {
        count += set[static_cast<size_t>((y + i / box) * kSide + x + i % box)];
      }
      sum += count;
      squares += count * count;
      ++boxes;
    }
  }
  const double mean = sum / boxes;
  spread.unevenness = (squares / boxes - mean * mean) / mean;
  return spread;
}

TEST(PixelOrderTest, EveryPixelOnceACycleForEveryLength) {
  constexpr Tile kOdd = {32, 64, 37, 29};
  for (int cycle = 1; cycle <= 256; ++cycle) {
    for (const int64_t start : {int64_t{0}, int64_t{7} * cycle, int64_t{-3} * cycle}) {
      std::vector<int> frame_of(static_cast<size_t>(kOdd.count()), -1);
      for (int f = 0; f < cycle; ++f) {
        const PixelOrder order(cycle, 11, start + f);
        ASSERT_EQ(order.cycle_index(), start / cycle);
        std::vector<PixelPosition> pixels;
        order.Collect(kOdd, &pixels);
        for (const PixelPosition& p : pixels) {
          ASSERT_TRUE(p.x >= 32 && p.x < 32 + 37 && p.y >= 64 && p.y < 64 + 29);
          int& at = frame_of[static_cast<size_t>((p.y - 64) * 37 + p.x - 32)];
          ASSERT_EQ(at, -1) << "cycle " << cycle << ": twice";
          at = f;
          ASSERT_EQ(order.FrameOf(p.x, p.y), f) << "cycle " << cycle;
        }
      }
      ASSERT_EQ(std::count(frame_of.begin(), frame_of.end(), -1), 0) << "cycle " << cycle;
    }
  }
}

TEST(PixelOrderTest, PixelsOfAFrameAreWellSpread) {
  for (const int cycle : {3, 5, 8, 13, 16, 30, 47, 64, 100, 128}) {
    const Spread random = MeasureSpread(RandomPixels(kSide * kSide / cycle));
    for (const int f : {0, 1, cycle / 2, cycle - 1}) {
      for (const int number : {0, 5}) {
        const Spread spread = MeasureSpread(PixelsOf(cycle, number * cycle + f));
        SCOPED_TRACE(::testing::Message() << "cycle " << cycle << ", frame " << f);
        // Where pixels lie close, distances have few values to choose from.
        EXPECT_GT(spread.nearest, (cycle < 8 ? 0.97 : 1.15) * random.nearest);
        EXPECT_GT(spread.nearest, 0.6);
        EXPECT_LT(spread.largest_gap, 1.15);
        EXPECT_LT(spread.unevenness, 0.35);
      }
    }
  }
}

TEST(PixelOrderTest, PixelsOfConsecutiveFramesAreWellSpread) {
  for (const int cycle : {40, 64, 128, 200, 256}) {
    for (const int count : {2, 4, 8, 16}) {
      for (const int first : {0, cycle / 3, cycle - count}) {
        const std::vector<PixelPosition> pixels = PixelsOfFrames(cycle, first, count);
        const Spread spread = MeasureSpread(pixels);
        SCOPED_TRACE(::testing::Message()
                     << "cycle " << cycle << ", frames " << first << " + " << count);
        const double random = MeasureSpread(RandomPixels(pixels.size())).nearest;
        EXPECT_GT(spread.nearest, (cycle / count < 8 ? 0.95 : 1.1) * random);
        EXPECT_LT(spread.largest_gap, 1.35);
        EXPECT_LT(spread.unevenness, 0.45);
      }
    }
  }
}

TEST(PixelOrderTest, FramesHaveTheSameNumberOfPixels) {
  for (const int cycle : {2, 7, 32, 128}) {
    for (int f = 0; f < cycle; f += 1 + cycle / 8) {
      const double expected = static_cast<double>(kSide) * kSide / cycle;
      EXPECT_NEAR(PixelsOf(cycle, f).size(), expected, 3 * std::sqrt(expected));
    }
  }
}

TEST(PixelOrderTest, CyclesAreIndependent) {
  // Where a pixel comes in one cycle says nothing about the next, nor about another seed.
  const auto correlation = [](const PixelOrder& a, const PixelOrder& b, int cycle) {
    double sum = 0;
    for (int y = 0; y < kSide; ++y) {
      for (int x = 0; x < kSide; ++x) {
        sum += ((a.FrameOf(x, y) + 0.5) / cycle - 0.5) * ((b.FrameOf(x, y) + 0.5) / cycle - 0.5);
      }
    }
    return sum / kSide / kSide * 12;
  };
  for (const int cycle : {4, 20, 128}) {
    // Pixels that come together again in the next cycle: by chance 1 / cycle of them.
    double together = 0;
    constexpr int kCycles = 24;
    for (int k = 0; k < kCycles; ++k) {
      const PixelOrder now(cycle, 3, k * cycle);
      const PixelOrder next(cycle, 3, (k + 1) * cycle);
      EXPECT_LT(std::abs(correlation(now, next, cycle)), 0.1) << cycle << ' ' << k;
      EXPECT_LT(std::abs(correlation(now, PixelOrder(cycle, 4, k * cycle), cycle)), 0.1);
      const std::vector<PixelPosition> pixels = PixelsOf(cycle, k * cycle, 3);
      int best = 0;
      std::vector<int> in_frame(static_cast<size_t>(cycle));
      for (const PixelPosition& p : pixels) {
        best = std::max(best, ++in_frame[static_cast<size_t>(next.FrameOf(p.x, p.y))]);
      }
      together += static_cast<double>(best) / static_cast<double>(pixels.size()) / kCycles;
    }
    EXPECT_LT(together, 0.2 + 1.3 / cycle) << cycle;
  }
}

}  // namespace
}  // namespace stillray::render::pixel_order_test
