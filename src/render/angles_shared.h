// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Trigonometric functions. The precision that Vulkan requires is too low (an error of one pixel of
// a large environment map), so in GLSL these are polynomials: S. Moshier's Cephes, atanf, to 2e-7
// relative.
#ifndef STILLRAY_RENDER_ANGLES_SHARED_H
#define STILLRAY_RENDER_ANGLES_SHARED_H

#ifdef __cplusplus
#include "render/shared.h"
#endif

STILLRAY_RENDER_BEGIN

// Polynomial arctangent of y / x for x, y >= 0: 0..pi/2, and 0 if both are 0.
SHARED_FN float ArcTangentOfQuarter(float y, float x) {
  const float kTan8th = 0.41421356f;  // tan(pi / 8)
  float larger = max(x, y);
  float t = larger > 0.0f ? min(x, y) / larger : 0.0f;
  float base = 0.0f;
  if (t > kTan8th) {
    t = (t - 1.0f) / (t + 1.0f);
    base = 0.25f * kPi;
  }
  float t2 = t * t;
  float p = (((8.05374449538e-2f * t2 - 1.38776856032e-1f) * t2 + 1.99777106478e-1f) * t2 -
             3.33329491539e-1f);
  float angle = base + (p * t2 * t + t);
  return y > x ? 0.5f * kPi - angle : angle;
}

// Polar angle of (x, y), -pi..pi.
SHARED_FN float PolynomialArcTangent(float y, float x) {
  float quarter = ArcTangentOfQuarter(abs(y), abs(x));
  float half_turn = x < 0.0f ? kPi - quarter : quarter;
  return y < 0.0f ? -half_turn : half_turn;
}

// Angle in 0..pi of a cosine in -1..1.
SHARED_FN float PolynomialArcCosine(float cosine) {
  return PolynomialArcTangent(sqrt((1.0f - cosine) * (1.0f + cosine)), cosine);
}

#ifdef __cplusplus
SHARED_FN float ArcTangent(float y, float x) {
  return std::atan2(y, x);
}
SHARED_FN float ArcCosine(float cosine) {
  return std::acos(cosine);
}
// (cos, sin).
SHARED_FN vec2 CosSin(float angle) {
  return vec2(std::cos(angle), std::sin(angle));
}
#else
float ArcTangent(float y, float x) {
  return PolynomialArcTangent(y, x);
}
float ArcCosine(float cosine) {
  return PolynomialArcCosine(cosine);
}
vec2 CosSin(float angle) {
  return CosSinOfTurn(fract(angle * (0.5f * kInvPi)));
}
#endif

STILLRAY_RENDER_END

#endif  // STILLRAY_RENDER_ANGLES_SHARED_H
