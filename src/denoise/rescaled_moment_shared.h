// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Second moments of light that is divided by another albedo.
#ifndef STILLRAY_DENOISE_RESCALED_MOMENT_SHARED_H
#define STILLRAY_DENOISE_RESCALED_MOMENT_SHARED_H

#ifdef __cplusplus
#include "core/colour_shared.h"
#include "core/shared.h"
#endif

SHARED_BEGIN

// The luminance of light divided by an albedo.
SHARED_FN float DividedLuminance(vec3 light, vec3 albedo) {
  return Luminance709(Demodulate(light.x, albedo.x), Demodulate(light.y, albedo.y),
                      Demodulate(light.z, albedo.z));
}

// A second moment that was divided by the square of the luminance of `before`, for `after`. The
// mean's part is exact only for grey albedos; it is that of all implementations.
// \param light  the mean that the moment belongs to
SHARED_FN float RescaledMoment(float moment, vec3 light, vec3 before, vec3 after) {
  float mean = DividedLuminance(light, before);
  float new_mean = DividedLuminance(light, after);
  float ratio = max(Luminance709(before.x, before.y, before.z), kAlbedoFloor) /
                max(Luminance709(after.x, after.y, after.z), kAlbedoFloor);
  return max(moment - mean * mean, 0.0f) * ratio * ratio + new_mean * new_mean;
}

SHARED_END

#endif
