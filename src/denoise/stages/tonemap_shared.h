// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Tone curves: scene-linear, exposed radiance to display-linear 0..1, per channel.
#ifndef STILLRAY_DENOISE_TONEMAP_SHARED_H
#define STILLRAY_DENOISE_TONEMAP_SHARED_H

#ifdef __cplusplus
#include "core/shared.h"
#endif

SHARED_BEGIN

SHARED_BLOCK(TonemapParameters) {
  float exposure_scale;  // 2^exposure
  int tonemap;           // 0 linear, 1 Reinhard, 2 filmic, 3 ACES
  float dither;          // noise added before rounding, in steps of the result: triangular, +- this
  uint frame;            // seed of the noise
};

// Larger values are white under every curve; the limit keeps infinities out of the formulas.
const float kBrightestLight = 1e6f;

SHARED_FN float ReinhardCurve(float x) {
  return x / (1.0f + x);
}

// Hable's filmic curve (Uncharted 2, GDC 2010), white at 11.2.
SHARED_FN float HableCurve(float x) {
  return (x * (0.15f * x + 0.05f) + 0.004f) / (x * (0.15f * x + 0.5f) + 0.06f) - 0.02f / 0.3f;
}
SHARED_FN float FilmicCurve(float x) {
  return HableCurve(2.0f * x) / HableCurve(11.2f);
}

// Narkowicz's fit of the ACES reference rendering and output transforms (2016), with the input
// scaled by 0.6, his value for the original exposure.
SHARED_FN float AcesCurve(float x) {
  float s = 0.6f * x;
  return clamp(s * (2.51f * s + 0.03f) / (s * (2.43f * s + 0.59f) + 0.14f), 0.0f, 1.0f);
}

// curve: 0 linear, 1 Reinhard, 2 filmic, 3 ACES.
SHARED_FN float ToneCurve(float x, int curve) {
  if (curve == 1) {
    return ReinhardCurve(x);
  }
  if (curve == 2) {
    return clamp(FilmicCurve(x), 0.0f, 1.0f);
  }
  if (curve == 3) {
    return AcesCurve(x);
  }
  return clamp(x, 0.0f, 1.0f);
}

// Triangular noise in -1..1 for one channel of one pixel: the sum of two uniform numbers from one
// hash, minus one.
SHARED_FN float DitherNoise(uint x, uint y, uint channel, uint frame) {
  uint h = x * 0x9e3779b1u ^ y * 0x85ebca77u ^ channel * 0xc2b2ae3du ^ frame * 0x27d4eb2fu;
  h ^= h >> 15;
  h *= 0x2c1b3c6du;
  h ^= h >> 12;
  h *= 0x297a2d39u;
  h ^= h >> 15;
  return (float(h & 0xffffu) + float(h >> 16)) * (1.0f / 65536.0f) - 1.0f;
}

// Rounds 0..1 to a byte. Black and white are unchanged, since noise would shift their mean.
SHARED_FN float DisplayStep(float display, float noise) {
  float value = display * 255.0f;
  float room = min(value, 255.0f - value);
  return value + clamp(noise, -room, room) + 0.5f;
}

SHARED_END

#endif
