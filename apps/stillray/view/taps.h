// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Bilinear resampling of rows of pixels.
#pragma once

#include <algorithm>
#include <cmath>

namespace stillray::view {

/// Two neighbouring pixels, and the weight of the second.
struct Taps {
  int first = 0;
  int second = 0;
  float weight = 0;
};

/// Taps for the centre of pixel i when `from` pixels are resampled to `to` pixels.
/// \param nearest  the weight is 0 or 1
inline Taps TapsAt(int i, int to, int from, bool nearest = false) {
  const float at =
      (static_cast<float>(i) + 0.5f) * static_cast<float>(from) / static_cast<float>(to) - 0.5f;
  const float low = std::floor(at);
  const auto first = static_cast<int>(low);
  const float weight = nearest ? std::round(at - low) : at - low;
  return {std::clamp(first, 0, from - 1), std::clamp(first + 1, 0, from - 1), weight};
}

inline float Mixed(float first, float second, float weight) {
  return first * (1 - weight) + second * weight;
}

}  // namespace stillray::view
