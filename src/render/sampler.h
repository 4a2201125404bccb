// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Random numbers of one path: which sequence a pixel draws from, and which point of it.
#pragma once

#include <cstdint>

#include "render/sampler_shared.h"
#include "stillray/render.h"

namespace stillray::render {

/// Which of a pixel's streams of random numbers; streams are independent of each other.
enum class SampleStream : uint32_t { kFrames = 0, kReference = 1 };

/// Hands out the random numbers of one path. A plain value: the same members, the same numbers.
struct PathSampler {
  SamplerKind kind = SamplerKind::kSobol;
  uint32_t index = 0;  ///< number of the sample within its sequence
  uint32_t seed = 0;   ///< of the pixel, the stream and the sequence

  /// Four numbers in [0, 1). \param set  which dimensions: kPrimaryDimensions, ScatterDimensions(),
  /// LightDimensions()
  vec4 Get(uint32_t set) const;
};

/// What the seeds of all pixels begin with (PixelSeed).
uint32_t StreamSeed(uint64_t seed, SampleStream stream);
/// The sampler of a stream: references are converged pictures, which need a long sequence.
/// \param chosen  RenderSettings::sampler, which frames use
SamplerKind SamplerOf(SampleStream stream, SamplerKind chosen);
/// Which sequence of a pixel holds sample number `sample`: beyond the length of one (2^kSobolBits
/// or kHaltonPeriod) a fresh one begins, with a scramble or rotation of its own.
uint64_t SampleWindow(SamplerKind kind, uint64_t sample);
/// Which of that sequence's samples it is.
uint32_t SampleIndex(uint64_t sample);

/// The sampler of sample number `sample` (counted over all frames) of pixel (x, y).
PathSampler MakePathSampler(SamplerKind kind, uint64_t seed, SampleStream stream, int x, int y,
                            uint64_t sample);

/// The jitter of a frame, -0.5..0.5 in pixels: Halton (2, 3), period 16.
vec2 FrameJitter(int64_t frame_index);

}  // namespace stillray::render
