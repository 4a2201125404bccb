// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "render/sampler.h"

namespace stillray::render {

static_assert(static_cast<uint32_t>(SamplerKind::kSobol) == kSamplerSobol &&
              static_cast<uint32_t>(SamplerKind::kHalton16) == kSamplerHalton16 &&
              static_cast<uint32_t>(SamplerKind::kZSobol) == kSamplerZSobol);

namespace {

/// SobolReversed for every value of the low and of the high byte of the index: the XOR of both
/// entries is the point, in two steps instead of sixteen.
struct SobolTables {
  uvec4 low[256];
  uvec4 high[256];

  explicit SobolTables(int first_dimension) {
    for (uint32_t i = 0; i < 256; ++i) {
      low[i] = SobolReversed(i, first_dimension);
      high[i] = SobolReversed(i << 8, first_dimension);
    }
  }
  uvec4 Point(uint32_t index) const { return low[index & 255u] ^ high[index >> 8]; }
};
static_assert(kSobolBits == 16);

const SobolTables& Tables() {
  static const SobolTables kTables(0);
  return kTables;
}

const SobolTables& BlockTables() {
  static const SobolTables kTables(kBlockFirstDimension);
  return kTables;
}

}  // namespace

vec4 PathSampler::Get(uint32_t set) const {
  if (kind == SamplerKind::kZSobol) {
    const uint32_t set_seed = HashCombine(BlockOfSeed(seed), set);
    const uint32_t i = BlockIndex(PositionOfSeed(seed), index, set_seed);
    return ScramblePoint(BlockTables().Point(i), set_seed);
  }
  const uint32_t set_seed = HashCombine(seed, set);
  if (kind == SamplerKind::kSobol) {
    return ScramblePoint(Tables().Point(ShuffledIndex(index, set_seed, kSobolBits)), set_seed);
  }
  return HaltonSample(index, set_seed, HashU32(set));
}

uint32_t StreamSeed(uint64_t seed, SampleStream stream) {
  const uint32_t h = HashCombine(static_cast<uint32_t>(seed), static_cast<uint32_t>(seed >> 32));
  return HashCombine(h, static_cast<uint32_t>(stream));
}

SamplerKind SamplerOf(SampleStream stream, SamplerKind chosen, int spp) {
  const bool too_many = chosen == SamplerKind::kZSobol && spp > kMostSppOfBlocks;
  return stream == SampleStream::kReference || too_many ? SamplerKind::kSobol : chosen;
}

uint64_t SampleWindow(SamplerKind kind, uint64_t sample) {
  switch (kind) {
    case SamplerKind::kSobol:
      return sample >> kSobolBits;
    case SamplerKind::kZSobol:
      return sample >> kBlockSampleBits;
    case SamplerKind::kHalton16:
      break;
  }
  return sample / kHaltonPeriod;
}

uint32_t SampleIndex(uint64_t sample) {
  return static_cast<uint32_t>(sample & ((1u << kSobolBits) - 1u));
}

PathSampler MakePathSampler(SamplerKind kind, uint64_t seed, SampleStream stream, int x, int y,
                            uint64_t sample) {
  const uint64_t window = SampleWindow(kind, sample);
  PathSampler sampler;
  sampler.kind = kind;
  sampler.index = SampleIndex(sample);
  sampler.seed = SamplerSeed(static_cast<uint32_t>(kind), StreamSeed(seed, stream),
                             static_cast<uint32_t>(x), static_cast<uint32_t>(y),
                             static_cast<uint32_t>(window), static_cast<uint32_t>(window >> 32));
  return sampler;
}

vec2 FrameJitter(int64_t frame_index) {
  const uint32_t i = static_cast<uint32_t>(frame_index & (kHaltonPeriod - 1)) + 1;
  return {RadicalInverse(i, 2) - 0.5f, RadicalInverse(i, 3) - 0.5f};
}

}  // namespace stillray::render
