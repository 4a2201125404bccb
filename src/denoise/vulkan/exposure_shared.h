// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The exposures: powers of two by which stored radiance is multiplied.
#ifndef STILLRAY_DENOISE_VULKAN_EXPOSURE_SHARED_H
#define STILLRAY_DENOISE_VULKAN_EXPOSURE_SHARED_H

#ifdef __cplusplus
#include "core/shared.h"
namespace stillray {
using glm::exp2;
using glm::floor;
using glm::log2;
}  // namespace stillray
#endif

SHARED_BEGIN

// Scales the mean radiance to about 1/8: half precision then covers values up to 500 000 times the
// mean, and keeps its 11 bits down to 1 / 2000 of the mean. The old exposure is kept while the
// scaled mean is within a factor of eight of 1/8, so that histories are seldom rescaled, and if the
// mean is zero.
SHARED_FN float ChooseExposure(float old, float mean) {
  float level = mean * old;
  bool fits = level >= 1.0f / 64.0f && level <= 1.0f;
  float chosen = exp2(clamp(-3.0f - floor(log2(max(mean, 1e-36f))), -100.0f, 100.0f));
  return mean > 0.0f ? (fits ? old : chosen) : (old > 0.0f ? old : 1.0f);
}

SHARED_END

#endif
