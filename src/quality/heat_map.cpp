// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "quality/heat_map.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "pictures/png.h"

namespace stillray::report {
namespace {

/// Equidistant colours of the ramp, which is linear between them. Their luminance increases, so
/// that the map can also be read in grey.
constexpr std::array<Rgb8, 8> kRampColours = {{{0, 0, 0},
                                               {45, 20, 95},
                                               {105, 30, 125},
                                               {165, 45, 110},
                                               {215, 75, 75},
                                               {245, 130, 40},
                                               {250, 195, 75},
                                               {255, 250, 210}}};
constexpr Rgb8 kNotFiniteColour = {0, 255, 128};
constexpr int kRampSize = kNotFiniteIndex;

std::array<Rgb8, 256> MakePalette() {
  std::array<Rgb8, 256> palette = {};
  for (int i = 0; i < kRampSize; ++i) {
    const float position =
        static_cast<float>(i) * (kRampColours.size() - 1) / static_cast<float>(kRampSize - 1);
    const size_t left = std::min(static_cast<size_t>(position), kRampColours.size() - 2);
    const float blend = position - static_cast<float>(left);
    for (size_t c = 0; c < 3; ++c) {
      const float value = (1 - blend) * kRampColours[left][c] + blend * kRampColours[left + 1][c];
      palette[static_cast<size_t>(i)][c] = static_cast<uint8_t>(std::lround(value));
    }
  }
  palette[kNotFiniteIndex] = kNotFiniteColour;
  return palette;
}

}  // namespace

const std::array<Rgb8, 256>& HeatPalette() {
  static const std::array<Rgb8, 256> palette = MakePalette();
  return palette;
}

uint8_t HeatIndex(float error, const HeatScale& scale) {
  if (!std::isfinite(error)) {
    return kNotFiniteIndex;
  }
  float position = 0;
  if (!scale.logarithmic) {
    position = (error - scale.low) / (scale.high - scale.low);
  } else if (error > scale.low) {
    position = std::log(error / scale.low) / std::log(scale.high / scale.low);
  }
  return static_cast<uint8_t>(std::lround(std::clamp(position, 0.0f, 1.0f) * (kRampSize - 1)));
}

Result<std::string> EncodeHeatMap(const Image1& errors, const HeatScale& scale) {
  const size_t width = static_cast<size_t>(errors.width());
  std::vector<uint8_t> indices(width * static_cast<size_t>(errors.height()));
  for (int y = 0; y < errors.height(); ++y) {
    const float* row = errors.Row(y);
    std::transform(row, row + errors.width(), &indices[static_cast<size_t>(y) * width],
                   [&scale](float error) { return HeatIndex(error, scale); });
  }
  return pictures::EncodePalettePng(errors.width(), errors.height(), indices, HeatPalette());
}

}  // namespace stillray::report
