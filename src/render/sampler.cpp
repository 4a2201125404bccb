// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "render/sampler.h"

namespace stillray::render {

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
