// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Colour formulas that several modules share. Each also stands in the tests, worked by hand.
#pragma once

#include <algorithm>
#include <cmath>

#include "stillray/vec.h"

namespace stillray {

/// Rec. 709 luminance of linear RGB.
inline float Luminance709(float r, float g, float b) {
  return 0.2126f * r + 0.7152f * g + 0.0722f * b;
}
inline float Luminance709(vec3 c) {
  return Luminance709(c.x, c.y, c.z);
}

/// Rec. 601 luma weights, as PSVGF (section 4.2) prints them.
inline float Luminance601(float r, float g, float b) {
  return 0.299f * r + 0.587f * g + 0.114f * b;
}

/// The smallest reflectance by which light is divided: below it the quotient would only amplify
/// rounding and fireflies. Multiplying by the same floored value gives the input back.
inline constexpr float kAlbedoFloor = 0.01f;

inline float Demodulate(float radiance, float albedo) {
  return radiance / std::max(albedo, kAlbedoFloor);
}
inline float Remodulate(float light, float albedo) {
  return light * std::max(albedo, kAlbedoFloor);
}
inline vec3 Demodulate(vec3 radiance, vec3 albedo) {
  return {Demodulate(radiance.x, albedo.x), Demodulate(radiance.y, albedo.y),
          Demodulate(radiance.z, albedo.z)};
}

/// IEC 61966-2-1 (sRGB) transfer curve; linear and encoded values in 0..1.
inline float SrgbEncode(float linear) {
  return linear <= 0.0031308f ? 12.92f * linear : 1.055f * std::pow(linear, 1.0f / 2.4f) - 0.055f;
}
inline float SrgbDecode(float encoded) {
  return encoded <= 0.04045f ? encoded / 12.92f : std::pow((encoded + 0.055f) / 1.055f, 2.4f);
}

}  // namespace stillray
