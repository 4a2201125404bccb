// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// prefilter_variance: the denominator of each pixel's luminance weight, from the variance around
/// it. Source: SVGF section 4.4 (g3x3 of the variance, eq. 5), PSVGF section 4.3: 3x3 (1 2 1) x (1
/// 2 1) / 16, renormalised over pixels that have light; missing ones are skipped, never filled. The
/// denominator is computed here, once per pixel instead of once per tap. Border: 1 pixel. Reads 8
/// to 16, writes 4 bytes per pixel.
#pragma once

#include "denoise/planes.h"
#include "denoise/stages/prefilter_variance_shared.h"

namespace stillray {

/// Planes of one signal.
struct PrefilterVarianceInput {
  const Image1* luminance;
  const Image1* variance;  ///< of the luminance
  const Image1* valid;     ///< positive where there is light on a surface, else 0 (border: 0)
  const Image1* length;    ///< history length, samples
  /// GuidePlanes::full if every surface has light: `valid` is then read at edges only. nullptr:
  /// unknown.
  const Plane<uint32_t>* full = nullptr;
};

/// \param factor  LuminanceFactor of every pixel; 0 where the luminance weight is 1: no light yet,
/// or
///     too short a history
namespace reference {
void PrefilterVariance(const PrefilterVarianceInput& in,
                       const PrefilterVarianceParameters& parameters, Image1* factor);
}
namespace cpu {
void PrefilterVariance(const PrefilterVarianceInput& in,
                       const PrefilterVarianceParameters& parameters, Image1* factor);
}  // namespace cpu

}  // namespace stillray
