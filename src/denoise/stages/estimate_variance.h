// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// estimate_variance: the variance of each pixel, the input of the wavelet's luminance weights.
/// Source: SVGF section 4.2: temporal moments; 7x7 (or 5x5) bilateral estimate over depth and
/// normal while the history is shorter than `short_length`. Departs: optionally the variance of the
/// accumulated mean instead of that of a single frame; a factor for short histories; and for short
/// histories the mean square of second differences along rows and columns (the residual of a local
/// plane, as in Immerkaer, Fast Noise Variance Estimation, 1996) in place of the spread about the
/// mean, which mistakes gradients of the radiance, such as the flanks of a highlight, for noise.
/// Signals share the geometry weights. Border: 3 pixels. Reads 16 and 12 per signal (and 7x7 x 16
/// and 12 per signal if the history is short), writes 4 bytes per pixel and signal.
#pragma once

#include <span>

#include "denoise/planes.h"
#include "denoise/stages/estimate_variance_shared.h"

namespace stillray {

/// One signal and its output.
struct VarianceSignal {
  const SignalHistory* history;
  /// Samples of this frame: the variance of a mean of n samples is 1/n of a single sample's.
  /// nullptr: one per pixel.
  const Image1* samples;
  Image1* variance;
  bool all_valid = false;  ///< [out] every surface has samples
};

namespace reference {
void EstimateVariance(std::span<VarianceSignal> signals, const GuidePlanes& guides,
                      const EstimateVarianceParameters& parameters);
}
namespace cpu {
void EstimateVariance(std::span<VarianceSignal> signals, const GuidePlanes& guides,
                      const EstimateVarianceParameters& parameters);
}

}  // namespace stillray
