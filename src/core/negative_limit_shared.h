// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The limit below which negative radiance is missing: see negative_limit.h.
#ifndef STILLRAY_CORE_NEGATIVE_LIMIT_SHARED_H
#define STILLRAY_CORE_NEGATIVE_LIMIT_SHARED_H

#ifdef __cplusplus
#include "core/shared.h"
namespace stillray {
using glm::exp2;
}  // namespace stillray
#endif

SHARED_BEGIN

// One bin per exponent of a float; bin 0 is for black pixels.
#define STILLRAY_LIGHT_BINS 256

// The bin of a radiance from the bits of its float. Negative values fall into bin 0.
SHARED_FN uint LightBin(uint bits) {
  return (bits & 0x80000000u) != 0u ? 0u : bits >> 23;
}

// The radiance that represents a bin: the middle of its octave, clamped so that the mean over any
// number of pixels stays in range.
SHARED_FN float LightOfBin(int bin) {
  return 1.5f * exp2(clamp(float(bin) - 127.0f, -90.0f, 90.0f));
}

// Number of brightest pixels that count as the next one, because they may be fireflies.
SHARED_FN uint BrightestPixels(uint measured) {
  return min(measured / 64u, 7u);
}

// Fraction of the mean radiance up to which negative radiance counts as zero. Rounding to halves is
// half of it, and the image becomes brighter by at most this fraction.
SHARED_FN float NegativeLimit(float mean_light) {
  return mean_light * (1.0f / 1024.0f);
}

SHARED_END

#endif
