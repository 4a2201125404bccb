// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Maps values to display colours. NaN is magenta and infinity cyan, to make them visible and
/// distinguishable.
#pragma once

#include <cstdint>
#include <optional>

namespace stillray::view {

struct Rgb8 {
  uint8_t r = 0;
  uint8_t g = 0;
  uint8_t b = 0;
  bool operator==(const Rgb8&) const = default;
};

inline constexpr Rgb8 kNanColour = {255, 0, 255};
inline constexpr Rgb8 kInfinityColour = {0, 255, 255};

/// The colour of a pixel with a non-finite value; NaN takes precedence over infinity.
std::optional<Rgb8> NotFiniteColour(float a, float b = 0, float c = 0);

/// sRGB encoding of 0..1; other values are clamped.
float ToSrgb(float linear);
/// Grey scale for 0..1, from black to white; clamped.
Rgb8 Grey(float value);
/// Heat map for 0..1: black, violet, red, yellow, white, with increasing luminance.
Rgb8 Heat(float value);
/// Colour of a unit vector; black for zero.
Rgb8 NormalColour(float x, float y, float z);
/// Colour of a motion vector: direction as hue (right: red), length as brightness, saturated at
/// `top` pixels (> 0).
Rgb8 MotionColour(float x, float y, float top);
/// Colour of an id, distinct for nearby ids; black for 0.
Rgb8 IdColour(uint32_t id);

}  // namespace stillray::view
