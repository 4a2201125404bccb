// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Parameters of how light becomes signals and signals light.
#ifndef STILLRAY_DENOISE_DEMODULATE_SHARED_H
#define STILLRAY_DENOISE_DEMODULATE_SHARED_H

#ifdef __cplusplus
#include "core/shared.h"
#endif

#include "core/colour_shared.h"

SHARED_BEGIN

SHARED_BLOCK(DemodulateParameters) {
  int demodulate;        // 1: light is divided by its albedo
  int luminance_rec601;  // 1: luminance weights of Rec. 601, 0: of Rec. 709
  int firefly;           // 0 off, 1 clamp, 2 compress
};

// Converts deviations of the luminance of a light that is divided by its own albedo into those of
// one channel of a signal. mean: of the pixel's samples, in that channel and in luminance; own,
// albedo: that channel of the light's own albedo and of the signal's. The hue of a pixel's samples
// is assumed to be constant: then its channels deviate in proportion to their means.
SHARED_FN float ChannelDeviation(float mean, float mean_luminance, float own, float albedo) {
  float hue = mean_luminance > 0.0f ? max(mean, 0.0f) / mean_luminance : 0.0f;
  return hue * max(own, kAlbedoFloor) / max(albedo, kAlbedoFloor);
}

SHARED_END

#endif
