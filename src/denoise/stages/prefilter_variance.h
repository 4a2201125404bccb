// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// prefilter_variance: the denominator of each pixel's luminance weight, from the variance around
/// it. Source: SVGF section 4.4 (g3x3 of the variance, eq. 5), PSVGF section 4.3: 3x3 (1 2 1) x (1
/// 2 1) / 16, renormalised over pixels with samples; missing pixels are skipped, never filled.
/// Departs from them: the result is at most `prefilter_limit` times the pixel's own variance. The
/// denominator is computed here, once per pixel instead of once per tap. Border: 1 pixel. Reads 8
/// to 16, writes 4 bytes per pixel. SmoothVariance is the other interpretation of the papers: the
/// variance itself is smoothed once, and all levels filter and compare the smoothed variance.
/// Border: 1 pixel. Reads 4 to 8, writes 4 bytes.
#pragma once

#include "core/shared.h"
#include "denoise/planes.h"
#include "denoise/stages/prefilter_variance_shared.h"

namespace stillray {

/// Planes of one signal.
struct PrefilterVarianceInput {
  const Image1* luminance;
  const Image1* variance;  ///< of the luminance
  const Image1* valid;     ///< positive for surfaces with samples, else 0 (border: 0)
  const Image1* length;    ///< history length, samples
  /// GuidePlanes::full if every surface has samples: `valid` is then read at edges only. nullptr:
  /// unknown.
  const Plane<uint32_t>* full = nullptr;
  /// Confidence in the last frame's radiance, for signals of volumes (VolumeWidening); nullptr:
  /// sigma_l is not widened.
  const Image1* confidence = nullptr;
};

/// Planes of one signal; members as in PrefilterVarianceInput.
struct SmoothVarianceInput {
  const Image1* variance;
  const Image1* valid;
  const Plane<uint32_t>* full = nullptr;
};

/// The mean of the variance around a pixel, weighted by (1 2 1) x (1 2 1) over pixels with samples;
/// 0 if there are none.
/// \param variance, valid  functions of (x, y) that return the value of a pixel; called for all
///     pixels within `radius` of (x, y)
template <typename Variance, typename Valid>
float SmoothedVariance(const Variance& variance, const Valid& valid, int radius, int x, int y) {
  float sum = 0;
  float sum_weight = 0;
  for (int dy = -radius; dy <= radius; ++dy) {
    for (int dx = -radius; dx <= radius; ++dx) {
      const float kernel = (dx == 0 ? 2.0f : 1.0f) * (dy == 0 ? 2.0f : 1.0f);
      const float w = valid(x + dx, y + dy) > 0 ? kernel : 0.0f;
      sum += w * variance(x + dx, y + dy);
      sum_weight += w;
    }
  }
  return sum / max(sum_weight, 1.0f);
}

/// \param factor  LuminanceFactor of every pixel; 0 where the luminance weight is 1: no samples, or
///     too short a history
/// \param out     the smoothed variance; pixels without samples keep their own
namespace reference {
void PrefilterVariance(const PrefilterVarianceInput& in,
                       const PrefilterVarianceParameters& parameters, Image1* factor);
void SmoothVariance(const SmoothVarianceInput& in, Image1* out);
}  // namespace reference
namespace cpu {
void PrefilterVariance(const PrefilterVarianceInput& in,
                       const PrefilterVarianceParameters& parameters, Image1* factor);
void SmoothVariance(const SmoothVarianceInput& in, Image1* out);
}  // namespace cpu

}  // namespace stillray
