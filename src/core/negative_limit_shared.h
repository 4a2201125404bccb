// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The limit below which negative light is missing: see negative_limit.h.
#ifndef STILLRAY_CORE_NEGATIVE_LIMIT_SHARED_H
#define STILLRAY_CORE_NEGATIVE_LIMIT_SHARED_H

#ifdef __cplusplus
#include "core/shared.h"
namespace stillray {
using glm::exp2;
}  // namespace stillray
#endif

SHARED_BEGIN

// One bin per exponent of a float; bin 0 holds pixels without light.
#define STILLRAY_LIGHT_BINS 256

// The bin of light from the bits of its float. Negative light falls into bin 0.
SHARED_FN uint LightBin(uint bits) {
  return (bits & 0x80000000u) != 0u ? 0u : bits >> 23;
}

// The light that a bin stands for: the middle of its octave, clamped to a range that the mean of
// any number of pixels stays within.
SHARED_FN float LightOfBin(int bin) {
  return 1.5f * exp2(clamp(float(bin) - 127.0f, -90.0f, 90.0f));
}

// How many of the brightest pixels count as much as the next one, because they may be fireflies.
SHARED_FN uint BrightestPixels(uint measured) {
  return min(measured / 64u, 7u);
}

// The fraction of the mean light below which negative light counts as zero. Half precision rounds
// by half of it, and the picture gets brighter by no more than it.
SHARED_FN float NegativeLimit(float mean_light) {
  return mean_light * (1.0f / 1024.0f);
}

SHARED_END

#endif
