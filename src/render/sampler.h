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

/// The sets of four dimensions that a path uses: two per ray it follows, and one for the primary
/// ray.
inline constexpr uint32_t kPrimaryDimensions = 0;
inline uint32_t ScatterDimensions(int step) {
  return 1u + 2u * static_cast<uint32_t>(step);
}
inline uint32_t LightDimensions(int step) {
  return 2u + 2u * static_cast<uint32_t>(step);
}

/// Hands out the random numbers of one path. A plain value: the same members, the same numbers.
struct PathSampler {
  SamplerKind kind = SamplerKind::kSobol;
  uint32_t index = 0;  ///< number of the sample within its sequence
  uint32_t seed = 0;   ///< of the pixel, the stream and the sequence

  /// Four numbers in [0, 1). \param set  which dimensions: kPrimaryDimensions, ScatterDimensions(),
  /// LightDimensions()
  vec4 Get(uint32_t set) const;
};

/// The sampler of sample number `sample` (counted over all frames) of pixel (x, y).
PathSampler MakePathSampler(SamplerKind kind, uint64_t seed, SampleStream stream, int x, int y,
                            uint64_t sample);

/// The jitter of a frame, -0.5..0.5 in pixels: Halton (2, 3), period 16.
vec2 FrameJitter(int64_t frame_index);

}  // namespace stillray::render
