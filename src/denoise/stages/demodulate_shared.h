// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Parameters of demodulation and remodulation.
#ifndef STILLRAY_DENOISE_DEMODULATE_SHARED_H
#define STILLRAY_DENOISE_DEMODULATE_SHARED_H

#ifdef __cplusplus
#include "core/shared.h"
#endif

#include "core/colour_shared.h"

SHARED_BEGIN

SHARED_BLOCK(DemodulateParameters) {
  int demodulate;        // 1: radiance is divided by its albedo
  int luminance_rec601;  // 1: luminance weights of Rec. 601, 0: of Rec. 709
  int firefly;           // 0 off, 1 clamp, 2 compress
};

// Factor from luminance deviations of a radiance divided by its own albedo to deviations of one
// channel of a signal. mean, mean_luminance: of the pixel's samples, in that channel and in
// luminance; own, albedo: that channel of the radiance's own albedo and of the signal's albedo. The
// hue of a pixel's samples is assumed to be constant, so that channels deviate in proportion to
// their means.
SHARED_FN float ChannelDeviation(float mean, float mean_luminance, float own, float albedo) {
  float hue = mean_luminance > 0.0f ? max(mean, 0.0f) / mean_luminance : 0.0f;
  return hue * max(own, kAlbedoFloor) / max(albedo, kAlbedoFloor);
}

SHARED_END

#endif
