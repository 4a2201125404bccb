// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Integer hashes: the only source of pseudo-random numbers. A number depends on its key (seed,
// pixel, frame, dimension) alone, never on the order of execution, so results do not depend on
// threads.
#ifndef STILLRAY_CORE_RANDOM_SHARED_H
#define STILLRAY_CORE_RANDOM_SHARED_H

#ifdef __cplusplus
#include "core/shared.h"
#endif

SHARED_BEGIN

// A bijective mix of 32 bits with good avalanche (lowbias32, found by C. Wellons' hash prospector).
SHARED_FN uint HashU32(uint x) {
  x ^= x >> 16;
  x *= 0x7feb352du;
  x ^= x >> 15;
  x *= 0x846ca68bu;
  x ^= x >> 16;
  return x;
}

SHARED_FN uint HashCombine(uint a, uint b) {
  return HashU32(a ^ (HashU32(b) + 0x9e3779b9u + (a << 6) + (a >> 2)));
}

SHARED_END

#endif  // STILLRAY_CORE_RANDOM_SHARED_H
