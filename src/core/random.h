// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Integer hashes: the only source of pseudo-random numbers. A number depends on its key (seed,
/// pixel, frame, dimension) alone, never on the order of execution, so results do not depend on
/// threads.
#pragma once

#include <cstdint>

namespace stillray {

/// A bijective mix of 32 bits with good avalanche (lowbias32, found by C. Wellons' hash
/// prospector).
inline uint32_t HashU32(uint32_t x) {
  x ^= x >> 16;
  x *= 0x7feb352du;
  x ^= x >> 15;
  x *= 0x846ca68bu;
  x ^= x >> 16;
  return x;
}

inline uint32_t HashCombine(uint32_t a, uint32_t b) {
  return HashU32(a ^ (HashU32(b) + 0x9e3779b9u + (a << 6) + (a >> 2)));
}

/// Uniform in [0, 1): the top 24 bits, so that the result is exact and never rounds up to 1.
inline float UniformFloat(uint32_t bits) {
  return static_cast<float>(bits >> 8) * 0x1p-24f;
}

}  // namespace stillray
