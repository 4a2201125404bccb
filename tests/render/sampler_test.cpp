// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "render/sampler.h"

#include <array>
#include <cmath>
#include <memory>
#include <set>
#include <vector>

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include "render/draw_numbers.h"

namespace stillray::render::sampler_test {
namespace {

// The first `bits` direction numbers m_k of a Sobol' dimension, from its primitive polynomial of
// degree s with inner coefficients a: Joe and Kuo (2008), eq. 2.
std::vector<uint32_t> DirectionNumbers(int s, uint32_t a, std::vector<uint32_t> m, int bits) {
  for (int k = s; k < bits; ++k) {
    uint32_t next = m[static_cast<size_t>(k - s)] ^ (m[static_cast<size_t>(k - s)] << s);
    for (int i = 1; i < s; ++i) {
      if ((a >> (s - 1 - i)) & 1u) {
        next ^= m[static_cast<size_t>(k - i)] << i;
      }
    }
    m.push_back(next);
  }
  return m;
}

TEST(SobolTest, DirectionsFollowFromThePolynomials) {
  const std::vector<std::vector<uint32_t>> numbers = {
      std::vector<uint32_t>(kSobolBits, 1u),  // van der Corput
      DirectionNumbers(1, 0, {1}, kSobolBits),
      DirectionNumbers(2, 1, {1, 3}, kSobolBits),
      DirectionNumbers(3, 1, {1, 3, 1}, kSobolBits),
      DirectionNumbers(3, 2, {1, 1, 1}, kSobolBits),
      DirectionNumbers(4, 1, {1, 1, 3, 3}, kSobolBits)};
  ASSERT_EQ(numbers.size(), static_cast<size_t>(kSobolDimensions));
  for (int bit = 0; bit < kSobolBits; ++bit) {
    for (int d = 0; d < kSobolDimensions; ++d) {
      const uint32_t fraction = numbers[static_cast<size_t>(d)][static_cast<size_t>(bit)]
                                << (31 - bit);
      EXPECT_EQ(kSobolDirections[kSobolDimensions * bit + d], ReverseBits(fraction))
          << bit << ' ' << d;
    }
  }
}

// Every elementary interval of area 1/n holds exactly one of the first n = 2^k points.
void ExpectNet(const std::vector<vec2>& points) {
  const auto n = static_cast<int>(points.size());
  for (int columns = 1; columns <= n; columns *= 2) {
    const int rows = n / columns;
    std::set<int> cells;
    for (const vec2& p : points) {
      cells.insert(static_cast<int>(p.x * static_cast<float>(columns)) * rows +
                   static_cast<int>(p.y * static_cast<float>(rows)));
    }
    EXPECT_EQ(cells.size(), points.size()) << columns << 'x' << rows;
  }
}

TEST(SobolTest, ScrambledPointsOfDimensions0And1AreNets) {
  for (const uint32_t seed : {0u, 1u, 77u, 0xdeadbeefu}) {
    for (const uint32_t n : {4u, 16u, 64u, 256u, 1024u}) {
      std::vector<vec2> points;
      for (uint32_t i = 0; i < n; ++i) {
        const vec4 u = SobolSample(i, seed);
        points.emplace_back(u.x, u.y);
      }
      ExpectNet(points);
    }
  }
}

TEST(SobolTest, EveryDimensionIsStratified) {
  for (const uint32_t seed : {3u, 99u}) {
    std::array<std::set<int>, 4> cells;
    for (uint32_t i = 0; i < 1024; ++i) {
      const vec4 u = SobolSample(i, seed);
      for (int d = 0; d < 4; ++d) {
        ASSERT_GE(u[d], 0.0f);
        ASSERT_LT(u[d], 1.0f);
        cells[static_cast<size_t>(d)].insert(static_cast<int>(u[d] * 1024.0f));
      }
    }
    for (const std::set<int>& c : cells) {
      EXPECT_EQ(c.size(), 1024u);
    }
  }
}

TEST(SobolTest, FramesContinueTheSequenceOfTheirPixel) {
  // Any aligned block of 16 successive samples of a pixel is a net of its own.
  for (uint64_t block = 0; block < 4; ++block) {
    std::vector<vec2> points;
    for (uint64_t i = 0; i < 16; ++i) {
      const vec4 u =
          MakePathSampler(SamplerKind::kSobol, 5, SampleStream::kFrames, 3, 4, block * 16 + i)
              .Get(ScatterDimensions(0));
      points.emplace_back(u.x, u.y);
    }
    ExpectNet(points);
  }
}

// Numbers of pixel (2, 3) differ from those of other pixels, sets, samples, streams and seeds.
// \param length  samples of a sequence
void ExpectOthersToDiffer(SamplerKind kind, const std::vector<ivec2>& pixels, uint64_t length) {
  const auto value = [kind](uint64_t seed, SampleStream stream, const ivec2& pixel, uint64_t i,
                            uint32_t set) {
    return MakePathSampler(kind, seed, stream, pixel.x, pixel.y, i).Get(set).x;
  };
  const ivec2 own(2, 3);
  const float base = value(1, SampleStream::kFrames, own, 4, 5);
  EXPECT_EQ(base, value(1, SampleStream::kFrames, own, 4, 5));
  EXPECT_NE(base, value(2, SampleStream::kFrames, own, 4, 5));
  EXPECT_NE(base, value(1ull << 40, SampleStream::kFrames, own, 4, 5));
  EXPECT_NE(base, value(1, SampleStream::kReference, own, 4, 5));
  EXPECT_NE(base, value(1, SampleStream::kFrames, own, 5, 5));
  EXPECT_NE(base, value(1, SampleStream::kFrames, own, 4 + length, 5));
  EXPECT_NE(base, value(1, SampleStream::kFrames, own, 4, 6));
  for (const ivec2& pixel : pixels) {
    EXPECT_NE(base, value(1, SampleStream::kFrames, pixel, 4, 5)) << pixel.x << ' ' << pixel.y;
  }
}

TEST(SobolTest, PixelsSetsStreamsAndSeedsDiffer) {
  ExpectOthersToDiffer(SamplerKind::kSobol, {{3, 2}}, 1u << kSobolBits);
}

TEST(SobolTest, TablesGiveWhatTheFormulaGives) {
  for (uint64_t i = 0; i < (1u << kSobolBits); i += 37) {
    const PathSampler s = MakePathSampler(SamplerKind::kSobol, 4, SampleStream::kFrames, 8, 9, i);
    ASSERT_EQ(s.Get(LightDimensions(2)),
              SobolSample(s.index, HashCombine(s.seed, LightDimensions(2))));
  }
}

// Two sets of dimensions must not be correlated: the mean of the product of centred values has a
// standard deviation of 1 / (12 sqrt(n)).
TEST(SobolTest, SetsAreUncorrelated) {
  constexpr int kCount = 4096;
  double sum = 0;
  for (uint64_t i = 0; i < kCount; ++i) {
    const PathSampler s = MakePathSampler(SamplerKind::kSobol, 0, SampleStream::kFrames, 0, 0, i);
    sum += (s.Get(ScatterDimensions(0)).x - 0.5) * (s.Get(ScatterDimensions(1)).x - 0.5);
  }
  EXPECT_LT(std::abs(sum / kCount), 5.0 / (12.0 * std::sqrt(kCount)));
}

PathSampler InBlock(int x, int y, uint64_t sample) {
  return MakePathSampler(SamplerKind::kZSobol, 5, SampleStream::kFrames, x, y, sample);
}

// In each coordinate, every interval of length 1/n holds exactly one of n numbers.
void ExpectStratified(const std::vector<vec4>& points) {
  const auto n = static_cast<float>(points.size());
  for (int d = 0; d < 4; ++d) {
    std::set<int> cells;
    for (const vec4& p : points) {
      ASSERT_GE(p[d], 0.0f);
      ASSERT_LT(p[d], 1.0f);
      cells.insert(static_cast<int>(p[d] * n));
    }
    EXPECT_EQ(cells.size(), points.size()) << d;
  }
}

TEST(ZSobolTest, MortonOrderWorkedByHand) {
  EXPECT_EQ(BlockPosition(0, 0), 0u);
  EXPECT_EQ(BlockPosition(1, 0), 1u);
  EXPECT_EQ(BlockPosition(0, 1), 2u);
  EXPECT_EQ(BlockPosition(3, 1), 7u);
  EXPECT_EQ(BlockPosition(8 + 5, 16 + 6), 0b111001u);
}

// The pixels of any aligned square in a frame, and of two squares side by side.
TEST(ZSobolTest, PixelsOfAFrameAreStratified) {
  for (const uint64_t sample : {0u, 1u, 5u, 1023u, 5000u}) {
    for (const uint32_t set : {kPrimaryDimensions, ScatterDimensions(0), LightDimensions(2)}) {
      for (const ivec2& size : {ivec2(2, 1), ivec2(2, 2), ivec2(4, 2), ivec2(4, 4), ivec2(8, 8)}) {
        for (int corner = 0; corner + size.x <= 16; corner += size.x) {
          std::vector<vec4> points;
          for (int y = 0; y < size.y; ++y) {
            for (int x = 0; x < size.x; ++x) {
              points.push_back(InBlock(corner + x, 24 + y, sample).Get(set));
            }
          }
          SCOPED_TRACE(testing::Message() << sample << ' ' << set << ' ' << corner);
          ExpectStratified(points);
        }
      }
    }
  }
}

// A view that stands still converges as with a sequence per pixel: each eighth of a coordinate has
// an eighth of 64 successive samples. The four dimensions and dimension 0, which selects the pixel,
// are pairs of primitive polynomials of degree 4 at most, hence nets of quality t = 3 (Sobol'
// 1967).
TEST(ZSobolTest, SamplesOfAPixelAreStratified) {
  for (const ivec2& pixel : {ivec2(0, 0), ivec2(3, 6), ivec2(29, 17)}) {
    for (const uint32_t set : {ScatterDimensions(0), LightDimensions(1)}) {
      for (uint64_t first = 0; first < 1024; first += 64) {
        int counts[4][8] = {};
        for (uint64_t i = first; i < first + 64; ++i) {
          const vec4 u = InBlock(pixel.x, pixel.y, i).Get(set);
          for (int d = 0; d < 4; ++d) {
            ++counts[d][static_cast<int>(u[d] * 8)];
          }
        }
        for (const auto& of_dimension : counts) {
          for (const int count : of_dimension) {
            EXPECT_EQ(count, 8);
          }
        }
      }
    }
  }
}

// Over space and time at once: each block has all points of a longer sequence.
TEST(ZSobolTest, SamplesOfABlockAreStratified) {
  std::vector<vec4> points;
  for (uint64_t sample = 16; sample < 32; ++sample) {
    for (int y = 8; y < 16; ++y) {
      for (int x = 0; x < 8; ++x) {
        points.push_back(InBlock(x, y, sample).Get(LightDimensions(0)));
      }
    }
  }
  ExpectStratified(points);
}

TEST(ZSobolTest, BlocksSetsSequencesStreamsAndSeedsDiffer) {
  ExpectOthersToDiffer(SamplerKind::kZSobol, {{3, 2}, {10, 3}, {2, 11}}, 1u << kBlockSampleBits);
}

// As SetsAreUncorrelated, and over the pixels of a frame.
TEST(ZSobolTest, SetsAreUncorrelated) {
  constexpr int kCount = 4096;
  double over_time = 0;
  double over_pixels = 0;
  for (int i = 0; i < kCount; ++i) {
    const auto product = [](const PathSampler& s) {
      return (s.Get(ScatterDimensions(0)).x - 0.5) * (s.Get(ScatterDimensions(1)).x - 0.5);
    };
    over_time += product(InBlock(0, 0, static_cast<uint64_t>(i)));
    over_pixels += product(InBlock(i % 64, i / 64, 3));
  }
  EXPECT_LT(std::abs(over_time / kCount), 5.0 / (12.0 * std::sqrt(kCount)));
  EXPECT_LT(std::abs(over_pixels / kCount), 5.0 / (12.0 * std::sqrt(kCount)));
}

// Why the sampler exists: the mean of a smooth function over 8x8 pixels has far less error than
// that of independent samples, 1 / (12 * 64) in squares, and over 64 samples of a pixel likewise.
TEST(ZSobolTest, MeansOverPixelsAndOverTimeHaveLittleError) {
  const auto squared_error = [](bool over_time) {
    double sum = 0;
    for (int block = 0; block < 100; ++block) {
      double mean = 0;
      for (int i = 0; i < 64; ++i) {
        const PathSampler s = over_time
                                  ? InBlock(8 * block + block % 8, 0, static_cast<uint64_t>(i))
                                  : InBlock(8 * block + i % 8, i / 8, 0);
        const vec4 u = s.Get(LightDimensions(0));
        mean += (u.x * u.y - 0.25) / 64;
      }
      sum += mean * mean / 100;
    }
    return sum;
  };
  const double independent = (1.0 / 9 - 1.0 / 16) / 64;
  EXPECT_LT(squared_error(false), independent / 20);
  EXPECT_LT(squared_error(true), independent / 20);
}

TEST(ZSobolTest, TablesGiveWhatTheFormulaGives) {
  for (uint64_t i = 0; i < 5000; i += 37) {
    const PathSampler s = InBlock(static_cast<int>(i % 41), static_cast<int>(i % 23), i);
    ASSERT_EQ(s.Get(LightDimensions(2)),
              PathNumbers(kSamplerZSobol, s.index, s.seed, LightDimensions(2)));
  }
}

TEST(HaltonTest, RadicalInversesWorkedByHand) {
  EXPECT_FLOAT_EQ(RadicalInverse(1, 2), 0.5f);
  EXPECT_FLOAT_EQ(RadicalInverse(2, 2), 0.25f);
  EXPECT_FLOAT_EQ(RadicalInverse(3, 2), 0.75f);
  EXPECT_FLOAT_EQ(RadicalInverse(6, 2), 0.375f);
  EXPECT_FLOAT_EQ(RadicalInverse(1, 3), 1.0f / 3);
  EXPECT_FLOAT_EQ(RadicalInverse(5, 3), 7.0f / 9);
  EXPECT_FLOAT_EQ(RadicalInverse(7, 5), 11.0f / 25);
  EXPECT_FLOAT_EQ(RadicalInverse(8, 7), 8.0f / 49);
}

TEST(HaltonTest, JitterIsHaltonWithPeriod16) {
  EXPECT_FLOAT_EQ(FrameJitter(0).x, 0.0f);
  EXPECT_FLOAT_EQ(FrameJitter(0).y, 1.0f / 3 - 0.5f);
  EXPECT_FLOAT_EQ(FrameJitter(1).x, -0.25f);
  EXPECT_FLOAT_EQ(FrameJitter(1).y, 2.0f / 3 - 0.5f);
  for (int i = 0; i < 16; ++i) {
    EXPECT_EQ(FrameJitter(i), FrameJitter(i + 16));
    EXPECT_NE(FrameJitter(i), FrameJitter(i + 1));
  }
}

// The cycle of each window of 16 samples has a rotation of its own; within it the 16 points differ.
TEST(HaltonTest, EveryCycleOfSixteenHasARotationOfItsOwn) {
  for (const uint32_t set : {kPrimaryDimensions, ScatterDimensions(0), LightDimensions(3)}) {
    const auto at = [set](uint64_t i) {
      return MakePathSampler(SamplerKind::kHalton16, 9, SampleStream::kFrames, 1, 2, i).Get(set);
    };
    std::set<float> different;
    for (uint64_t i = 0; i < 64; ++i) {
      different.insert(at(i).x);
    }
    EXPECT_EQ(different.size(), 64u);
    for (uint64_t i = 0; i < 16; ++i) {
      // One shift, modulo 1, leads from all points of a cycle to those of the next.
      const vec4 shift = fract(at(i + 16) - at(i) + vec4(2.0f));
      const vec4 first = fract(at(16) - at(0) + vec4(2.0f));
      for (int d = 0; d < 4; ++d) {
        const float apart = std::abs(shift[d] - first[d]);
        EXPECT_LT(std::min(apart, 1.0f - apart), 1e-5f) << set << ' ' << i << ' ' << d;
      }
    }
  }
}

// The points of the SVGF recipe: the numbers of earlier versions stay.
TEST(HaltonTest, TheFirstSixteenKeepTheirBits) {
  const PathSampler sampler =
      MakePathSampler(SamplerKind::kHalton16, 9, SampleStream::kFrames, 1, 2, 15);
  EXPECT_EQ(sampler.seed, PixelSeed(StreamSeed(9, SampleStream::kFrames), 1u, 2u, 0u, 0u));
  EXPECT_EQ(sampler.index, 15u);
}

TEST(HaltonTest, ReferencesDrawFromSobol) {
  for (const SamplerKind kind :
       {SamplerKind::kSobol, SamplerKind::kHalton16, SamplerKind::kZSobol}) {
    EXPECT_EQ(SamplerOf(SampleStream::kFrames, kind, 1), kind);
    EXPECT_EQ(SamplerOf(SampleStream::kReference, kind, 1), SamplerKind::kSobol);
  }
}

TEST(ZSobolTest, PixelsOfManySamplesHaveTheirOwnSequence) {
  const auto of_frames = [](SamplerKind kind, int spp) {
    return SamplerOf(SampleStream::kFrames, kind, spp);
  };
  EXPECT_EQ(of_frames(SamplerKind::kZSobol, kMostSppOfBlocks), SamplerKind::kZSobol);
  EXPECT_EQ(of_frames(SamplerKind::kZSobol, kMostSppOfBlocks + 1), SamplerKind::kSobol);
  EXPECT_EQ(of_frames(SamplerKind::kHalton16, 100), SamplerKind::kHalton16);
}

TEST(SamplerTest, ManyAtOnceAreTheSameAsOneByOne) {
  for (const int64_t target : hwy::SupportedAndGeneratedTargets()) {
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    for (const SamplerKind kind :
         {SamplerKind::kSobol, SamplerKind::kHalton16, SamplerKind::kZSobol}) {
      auto samplers = std::make_unique<SamplerBatch>();
      auto numbers = std::make_unique<NumberBatch>();
      std::vector<PathSampler> single;
      for (int i = 0; i < 1001; ++i) {
        const auto sample = static_cast<uint64_t>(i) * 7919u;
        single.push_back(MakePathSampler(kind, 3, SampleStream::kFrames, i % 37, i / 37, sample));
        samplers->Push(single.back(), ScatterDimensions(i % 30));
      }
      DrawNumbers(*samplers, 1, numbers.get());
      for (int i = 0; i < samplers->count; ++i) {
        EXPECT_EQ(numbers->Get(i), single[static_cast<size_t>(i)].Get(LightDimensions(i % 30)))
            << hwy::TargetName(target) << " " << i;
      }
    }
  }
  hwy::SetSupportedTargetsForTest(0);
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
}

}  // namespace
}  // namespace stillray::render::sampler_test
