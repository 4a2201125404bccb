// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Per-pixel errors as a heat map: from dark (none) to bright (large).
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "stillray/image.h"
#include "stillray/status.h"

namespace stillray::report {

using Rgb8 = std::array<uint8_t, 3>;

/// The map from errors to positions on the colour ramp. FLIP lies in 0..1; relative squared error
/// spans too many powers of ten for a linear scale.
struct HeatScale {
  bool logarithmic = false;
  float low = 0;   ///< error at the ramp's start; > 0 if logarithmic
  float high = 1;  ///< error at the ramp's end, > low
};
inline constexpr HeatScale kFlipScale = {false, 0.0f, 1.0f};
inline constexpr HeatScale kRelativeSquaredErrorScale = {true, 1e-4f, 10.0f};

/// Index of the palette's colour for pixels whose error is not a finite number.
inline constexpr int kNotFiniteIndex = 255;

/// The ramp: entries 0..254 from black over violet, red and orange to pale yellow, increasing in
/// lightness; the last entry is a green that does not occur in the ramp.
const std::array<Rgb8, 256>& HeatPalette();

/// Palette index of an error, clamped to the scale's ends.
uint8_t HeatIndex(float error, const HeatScale& scale);

/// The bytes of a palette PNG file of the size of `errors`.
Result<std::string> EncodeHeatMap(const Image1& errors, const HeatScale& scale);

}  // namespace stillray::report
