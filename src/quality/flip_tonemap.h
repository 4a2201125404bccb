// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// HDR-FLIP's tone mapping of radiance to display images (Andersson, Nilsson, Shirley and
/// Akenine-Moeller, "Visualizing Errors in Rendered High Dynamic Range Images", 2021, section 3).
#pragma once

#include <algorithm>
#include <cmath>

#include "quality/metrics.h"

namespace stillray::quality {

/// (k0 x^2 + k1 x) / (k3 x^2 + k4 x + k5): Narkowicz' fit of the ACES curve, its constants 2.51,
/// 0.03, 2.43, 0.59, 0.14 merged with the factor 0.6 that matches the original's exposure.
struct FlipAces {
  static constexpr double kSquare = 2.51 * 0.6 * 0.6;
  static constexpr double kLinear = 0.03 * 0.6;
  static constexpr double kBelowSquare = 2.43 * 0.6 * 0.6;
  static constexpr double kBelowLinear = 0.59 * 0.6;
  static constexpr double kBelowConstant = 0.14;
};

/// Maps a linear value to the linear value, 0..1, that the display shows.
class FlipTonemap {
 public:
  explicit FlipTonemap(const Exposure& exposure)
      : tonemap_(exposure.tonemap), scale_(std::exp2(exposure.stops)) {}

  float operator()(float value) const {
    const float positive = value > 0.0f ? value : 0.0f;
    if (!tonemap_) {
      return std::min(positive, 1.0f);
    }
    // Above the limit the curve exceeds 1, where it is clipped, and its squares would overflow.
    constexpr double kLimit = 1e4;
    const float x = static_cast<float>(std::min(positive * scale_, kLimit));
    using A = FlipAces;
    const float above = (static_cast<float>(A::kSquare) * x + static_cast<float>(A::kLinear)) * x;
    const float below =
        (static_cast<float>(A::kBelowSquare) * x + static_cast<float>(A::kBelowLinear)) * x +
        static_cast<float>(A::kBelowConstant);
    return std::min(above / below, 1.0f);
  }

 private:
  bool tonemap_;
  double scale_;
};

}  // namespace stillray::quality
