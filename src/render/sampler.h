// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Random numbers of one path: the sequence of its pixel, and the sample's index in the sequence.
#pragma once

#include <cstdint>

#include "render/sampler_shared.h"
#include "stillray/render.h"

namespace stillray::render {

/// Independent streams of a pixel's random numbers.
enum class SampleStream : uint32_t { kFrames = 0, kReference = 1 };

/// The random numbers of one path. A plain value: equal members yield equal numbers.
struct PathSampler {
  SamplerKind kind = SamplerKind::kSobol;
  uint32_t index = 0;  ///< number of the sample within its sequence
  uint32_t seed = 0;   ///< hash of pixel, stream and sequence (SamplerSeed)

  /// Four numbers in [0, 1). \param set  set of dimensions: kPrimaryDimensions, kLensDimensions,
  /// ScatterDimensions(), LightDimensions()
  vec4 Get(uint32_t set) const;
};

/// The part of the seed that is common to all pixels (PixelSeed).
uint32_t StreamSeed(uint64_t seed, SampleStream stream);
/// The sampler of a stream. References are converged images, which need a long sequence. Above
/// kMostSppOfBlocks, stratification within the pixel has less error than stratification across
/// neighbouring pixels (measured: docs/scenes.md), and kZSobol becomes kSobol.
/// \param chosen  RenderSettings::sampler, used for frames
/// \param spp     RenderSettings::spp
SamplerKind SamplerOf(SampleStream stream, SamplerKind chosen, int spp);
inline constexpr int kMostSppOfBlocks = 2;
/// Number of the pixel's sequence that contains sample `sample`. Sequences have a length of
/// 2^kSobolBits, 2^kBlockSampleBits or kHaltonPeriod and differ in scramble or rotation.
uint64_t SampleWindow(SamplerKind kind, uint64_t sample);
/// Index of the sample within its sequence (SampleWindow).
uint32_t SampleIndex(uint64_t sample);

/// The sampler of sample number `sample` (counted over all frames) of pixel (x, y).
PathSampler MakePathSampler(SamplerKind kind, uint64_t seed, SampleStream stream, int x, int y,
                            uint64_t sample);

/// The jitter of a frame, -0.5..0.5 in pixels: Halton (2, 3), period 16.
vec2 FrameJitter(int64_t frame_index);

}  // namespace stillray::render
