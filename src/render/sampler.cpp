// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "render/sampler.h"

namespace stillray::render {

static_assert(static_cast<uint32_t>(SamplerKind::kSobol) == kSamplerSobol &&
              static_cast<uint32_t>(SamplerKind::kHalton16) == kSamplerHalton16);

namespace {

/// SobolReversed for every value of the low and of the high byte of the index: their exclusive or
/// is the point, in two steps instead of sixteen.
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
  const uint32_t set_seed = HashCombine(seed, set);
  if (kind == SamplerKind::kSobol) {
    const uint32_t i = ShuffledIndex(index, set_seed);
    const SobolTables& tables = Tables();
    return ScramblePoint(tables.low[i & 255u] ^ tables.high[i >> 8], set_seed);
  }
  return HaltonSample(index, set_seed, HashU32(set));
}

uint32_t StreamSeed(uint64_t seed, SampleStream stream) {
  const uint32_t h = HashCombine(static_cast<uint32_t>(seed), static_cast<uint32_t>(seed >> 32));
  return HashCombine(h, static_cast<uint32_t>(stream));
}

SamplerKind SamplerOf(SampleStream stream, SamplerKind chosen) {
  return stream == SampleStream::kReference ? SamplerKind::kSobol : chosen;
}

uint64_t SampleWindow(SamplerKind kind, uint64_t sample) {
  return kind == SamplerKind::kSobol ? sample >> kSobolBits : sample / kHaltonPeriod;
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
  sampler.seed =
      PixelSeed(StreamSeed(seed, stream), static_cast<uint32_t>(x), static_cast<uint32_t>(y),
                static_cast<uint32_t>(window), static_cast<uint32_t>(window >> 32));
  return sampler;
}

vec2 FrameJitter(int64_t frame_index) {
  const uint32_t i = static_cast<uint32_t>(frame_index & (kHaltonPeriod - 1)) + 1;
  return {RadicalInverse(i, 2) - 0.5f, RadicalInverse(i, 3) - 0.5f};
}

}  // namespace stillray::render
