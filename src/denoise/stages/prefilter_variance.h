// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// prefilter_variance: the spread that the luminance weight divides by.
/// Source: SVGF section 4.4 (g3x3 of the variance, eq. 5), PSVGF section 4.3: 3x3 (1 2 1) x (1 2 1)
/// / 16, renormalised over pixels that have light; missing ones are skipped, never filled. Border:
/// 1 pixel. Reads 12, writes 4 bytes per pixel.
#pragma once

#include "denoise/planes.h"

namespace stillray {

/// Spread of pixels whose luminance must not stop anything: no light yet, or too short a history.
inline constexpr float kUnboundedSpread = 1e30f;

struct PrefilterVarianceParameters {
  bool smooth = true;         ///< off: the pixel's own variance
  bool square_root = true;    ///< standard deviation; off: the variance (PSVGF as printed)
  float unbounded_below = 0;  ///< history length below which the spread is kUnboundedSpread
};

/// \param present  1 where there is light on a surface, else 0 (border: 0)
/// \param length   history length, samples
namespace reference {
void PrefilterVariance(const Image1& variance, const Image1& present, const Image1& length,
                       const PrefilterVarianceParameters& parameters, Image1* spread);
}
namespace cpu {
void PrefilterVariance(const Image1& variance, const Image1& present, const Image1& length,
                       const PrefilterVarianceParameters& parameters, Image1* spread);
}

}  // namespace stillray
