// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "render/sampler.h"

namespace stillray::render {
namespace {

// SobolReversed for every value of the low and of the high byte of the index: its exclusive or
// makes the point in two steps, where bit by bit takes sixteen.
struct SobolTables {
  uvec4 low[256];
  uvec4 high[256];

  SobolTables() {
    for (uint32_t i = 0; i < 256; ++i) {
      low[i] = SobolReversed(i);
      high[i] = SobolReversed(i << 8);
    }
  }
};
static_assert(kSobolBits == 16);

const SobolTables& Tables() {
  static const SobolTables kTables;
  return kTables;
}

}  // namespace

vec4 PathSampler::Get(uint32_t set) const {
  const uint32_t set_seed = MixSeeds(seed, set);
  if (kind == SamplerKind::kSobol) {
    const uint32_t i = ShuffledIndex(index, set_seed);
    const SobolTables& tables = Tables();
    return ScramblePoint(tables.low[i & 255u] ^ tables.high[i >> 8], set_seed);
  }
  return HaltonSample(index, set_seed, MixBits(set));
}

PathSampler MakePathSampler(SamplerKind kind, uint64_t seed, SampleStream stream, int x, int y,
                            uint64_t sample) {
  // Beyond the length of one sequence a fresh one begins, with a scramble of its own. The Halton
  // cycle keeps its rotation for ever: that is what SVGF describes.
  const uint64_t window = kind == SamplerKind::kSobol ? sample >> kSobolBits : 0;
  uint32_t h = MixSeeds(static_cast<uint32_t>(seed), static_cast<uint32_t>(seed >> 32));
  h = MixSeeds(h, static_cast<uint32_t>(stream));
  h = MixSeeds(h, static_cast<uint32_t>(x));
  h = MixSeeds(h, static_cast<uint32_t>(y));
  if (window != 0) {
    h = MixSeeds(h, static_cast<uint32_t>(window));
    h = MixSeeds(h, static_cast<uint32_t>(window >> 32));
  }
  PathSampler sampler;
  sampler.kind = kind;
  sampler.index = static_cast<uint32_t>(sample & ((1u << kSobolBits) - 1u));
  sampler.seed = h;
  return sampler;
}

vec2 FrameJitter(int64_t frame_index) {
  const uint32_t i = static_cast<uint32_t>(frame_index & (kHaltonPeriod - 1)) + 1;
  return {RadicalInverse(i, 2) - 0.5f, RadicalInverse(i, 3) - 0.5f};
}

}  // namespace stillray::render
