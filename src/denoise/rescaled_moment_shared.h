// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Conversion of second moments from one albedo to another.
#ifndef STILLRAY_DENOISE_RESCALED_MOMENT_SHARED_H
#define STILLRAY_DENOISE_RESCALED_MOMENT_SHARED_H

#ifdef __cplusplus
#include "core/colour_shared.h"
#include "core/shared.h"
#endif

SHARED_BEGIN

// The luminance of radiance divided by an albedo.
SHARED_FN float DividedLuminance(vec3 light, vec3 albedo) {
  return Luminance709(Demodulate(light.x, albedo.x), Demodulate(light.y, albedo.y),
                      Demodulate(light.z, albedo.z));
}

// Converts a second moment of radiance divided by `before` to that of radiance divided by `after`:
// the variance is scaled by the squared ratio of the albedos' luminances, which is exact only for
// grey albedos. All implementations use this formula.
// \param light  the mean radiance of the pixel
SHARED_FN float RescaledMoment(float moment, vec3 light, vec3 before, vec3 after) {
  float mean = DividedLuminance(light, before);
  float new_mean = DividedLuminance(light, after);
  float ratio = max(Luminance709(before.x, before.y, before.z), kAlbedoFloor) /
                max(Luminance709(after.x, after.y, after.z), kAlbedoFloor);
  return max(moment - mean * mean, 0.0f) * ratio * ratio + new_mean * new_mean;
}

SHARED_END

#endif
