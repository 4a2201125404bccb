// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "view/colour_maps.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace stillray::view {
namespace {

uint8_t Byte(float value) {
  return static_cast<uint8_t>(std::lround(std::clamp(value, 0.0f, 1.0f) * 255.0f));
}

/// Hue in 0..1 of full saturation, times `value`.
Rgb8 HueColour(float hue, float value) {
  const auto channel = [&](float shift) {
    const float t = hue + shift - std::floor(hue + shift);
    return Byte(value * std::clamp(std::abs(t * 6 - 3) - 1, 0.0f, 1.0f));
  };
  return {channel(0), channel(2.0f / 3), channel(1.0f / 3)};
}

}  // namespace

std::optional<Rgb8> NotFiniteColour(float a, float b, float c) {
  if (std::isnan(a) || std::isnan(b) || std::isnan(c)) {
    return kNanColour;
  }
  if (std::isinf(a) || std::isinf(b) || std::isinf(c)) {
    return kInfinityColour;
  }
  return std::nullopt;
}

float ToSrgb(float linear) {
  const float c = std::clamp(linear, 0.0f, 1.0f);
  return c <= 0.0031308f ? 12.92f * c : 1.055f * std::pow(c, 1 / 2.4f) - 0.055f;
}

Rgb8 Grey(float value) {
  if (const std::optional<Rgb8> colour = NotFiniteColour(value)) {
    return *colour;
  }
  const uint8_t g = Byte(value);
  return {g, g, g};
}

Rgb8 Heat(float value) {
  if (const std::optional<Rgb8> colour = NotFiniteColour(value)) {
    return *colour;
  }
  // Luminance increases from stop to stop.
  static constexpr float kStops[6][3] = {{0.00f, 0.00f, 0.02f}, {0.23f, 0.06f, 0.44f},
                                         {0.62f, 0.15f, 0.40f}, {0.93f, 0.36f, 0.14f},
                                         {0.98f, 0.74f, 0.15f}, {1.00f, 1.00f, 0.92f}};
  const float at = std::clamp(value, 0.0f, 1.0f) * 5;
  const int i = std::min(static_cast<int>(at), 4);
  const float t = at - static_cast<float>(i);
  const auto mix = [&](int c) { return Byte(kStops[i][c] * (1 - t) + kStops[i + 1][c] * t); };
  return {mix(0), mix(1), mix(2)};
}

Rgb8 NormalColour(float x, float y, float z) {
  if (const std::optional<Rgb8> colour = NotFiniteColour(x, y, z)) {
    return *colour;
  }
  if (x == 0 && y == 0 && z == 0) {
    return {};
  }
  return {Byte(x * 0.5f + 0.5f), Byte(y * 0.5f + 0.5f), Byte(z * 0.5f + 0.5f)};
}

Rgb8 MotionColour(float x, float y, float top) {
  if (const std::optional<Rgb8> colour = NotFiniteColour(x, y)) {
    return *colour;
  }
  const float length = std::hypot(x, y);
  const float angle = std::atan2(y, x) / (2 * std::numbers::pi_v<float>);
  return HueColour(angle, std::min(length / top, 1.0f));
}

Rgb8 IdColour(uint32_t id) {
  if (id == 0) {
    return {};
  }
  // Steps of the golden ratio distribute hues evenly for any number of ids.
  const double hue = id * 0.6180339887498949;
  const float value = 0.55f + 0.45f * static_cast<float>(id % 3) / 2;
  return HueColour(static_cast<float>(hue - std::floor(hue)), value);
}

}  // namespace stillray::view
