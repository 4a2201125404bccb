// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// estimate_variance: the variance that the wavelet must remove from each pixel. Source: SVGF
/// section 4.2: temporal moments; 7x7 (or 5x5) bilateral estimate over depth and normal while the
/// history is shorter than `short_length`. Departs: optionally the variance of the accumulated mean
/// instead of a frame's, a factor for short histories, and for these the mean square of second
/// differences along rows and columns (the residual of a local plane, as in Immerkaer, Fast Noise
/// Variance Estimation, 1996) in place of the spread about the mean, which takes slopes of the
/// light, such as the flanks of a highlight, for noise. Signals share the weights of the guides.
/// Border: 3 pixels. Reads 16 and 12 per signal (and 7x7 x 16 and 12 per signal if the history is
/// short), writes 4 bytes per pixel and signal.
#pragma once

#include <span>

#include "denoise/planes.h"
#include "denoise/stages/estimate_variance_shared.h"

namespace stillray {

/// One signal and its output.
struct VarianceSignal {
  const SignalHistory* history;
  /// Of this frame: a frame of n samples per pixel has 1/n of a sample's. nullptr: one.
  const Image1* samples;
  Image1* variance;
  bool all_valid = false;  ///< set by the stage: every surface has light
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
