// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Colour formulas shared by all modules. Each is tested against values computed by hand.
#ifndef STILLRAY_CORE_COLOUR_SHARED_H
#define STILLRAY_CORE_COLOUR_SHARED_H

#ifdef __cplusplus
#include "core/shared.h"
#endif

SHARED_BEGIN

// Rec. 709 luminance of linear RGB.
SHARED_FN float Luminance709(float r, float g, float b) {
  return 0.2126f * r + 0.7152f * g + 0.0722f * b;
}

// Rec. 601 luma weights, as printed in PSVGF (section 4.2).
SHARED_FN float Luminance601(float r, float g, float b) {
  return 0.299f * r + 0.587f * g + 0.114f * b;
}

// Green of a colour given as (luminance, red, blue). All filters are linear, so they can run in
// this basis, where the luminance is a channel.
SHARED_FN float Green709(float l, float r, float b) {
  return max((l - 0.2126f * r - 0.0722f * b) / 0.7152f, 0.0f);
}
SHARED_FN float Green601(float l, float r, float b) {
  return max((l - 0.299f * r - 0.114f * b) / 0.587f, 0.0f);
}

// Minimum divisor in demodulation: a smaller reflectance would only amplify rounding errors and
// fireflies. Remodulation with the same clamped value restores the input.
const float kAlbedoFloor = 0.01f;

SHARED_FN float Demodulate(float radiance, float albedo) {
  return radiance / max(albedo, kAlbedoFloor);
}
SHARED_FN float Remodulate(float light, float albedo) {
  return light * max(albedo, kAlbedoFloor);
}

// IEC 61966-2-1 (sRGB) transfer curve; linear and encoded values in 0..1.
SHARED_FN float SrgbEncode(float linear_value) {
  return linear_value <= 0.0031308f ? 12.92f * linear_value
                                    : 1.055f * pow(linear_value, 1.0f / 2.4f) - 0.055f;
}
SHARED_FN float SrgbDecode(float encoded) {
  return encoded <= 0.04045f ? encoded / 12.92f : pow((encoded + 0.055f) / 1.055f, 2.4f);
}

SHARED_END

#endif
