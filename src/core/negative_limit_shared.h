// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// How far below zero light may lie and still count as zero: see negative_limit.h.
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

// The bin of light whose float has these bits. Negative light is no light here.
SHARED_FN uint LightBin(uint bits) {
  return (bits & 0x80000000u) != 0u ? 0u : bits >> 23;
}

// What light of a bin counts as: the middle of its octave, within a range that the mean of any
// number of pixels cannot leave.
SHARED_FN float LightOfBin(int bin) {
  return 1.5f * exp2(clamp(float(bin) - 127.0f, -90.0f, 90.0f));
}

// So many of the brightest pixels count no more than the next one: fireflies.
SHARED_FN uint BrightestPixels(uint measured) {
  return min(measured / 64u, 7u);
}

// The part of the mean light below which negative light is zero: half precision rounds by half as
// much, and the picture cannot get brighter by more than this part.
SHARED_FN float NegativeLimit(float mean_light) {
  return mean_light * (1.0f / 1024.0f);
}

SHARED_END

#endif
