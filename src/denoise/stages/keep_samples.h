// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// keep_samples: pixels with several samples keep them where their noise is smaller than the error
/// of the filter. The wavelet removes detail that it cannot distinguish from noise, and the history
/// blurs it. This bias does not decrease with the number of samples, while the noise does: above
/// some number the noisy image would be better than the filtered one. The filtered signal y is
/// blended with this frame's signal x. Source: James and Stein 1961; Green and Strawderman 1991, "A
/// James-Stein type estimator for combining unbiased and possibly biased estimators": the squared
/// bias of y is the excess of the mean of (x - y)^2 over the variance of x. Both are means of three
/// geometry-only wavelet levels. The variance is the larger one of the estimate from the samples
/// within pixels and the estimate from the history: rare bright samples are missing in most frames.
/// As the noise goes to zero the result goes to x, and so converges to the reference. Where the
/// variance within a pixel is estimated from its neighbours (frames of other renderers), the
/// deviation x - y is limited (ShareOfFiltered): means hide a rare bright sample, and single pixels
/// would return as specks. Pixels with one sample stay unchanged, bit for bit. Departs from SVGF,
/// which has no such stage. No state. Border: as for these levels. Reads 44, writes 28 bytes per
/// pixel and signal around the wavelet.
#pragma once

#include "denoise/planes.h"
#include "denoise/stages/keep_samples_shared.h"

namespace stillray {

inline constexpr int kKeepSamplesLevels = 3;

struct KeepSamplesInput {
  const NewLight* light;       ///< x, of this frame; its `within` is not empty
  const LumaImage3* filtered;  ///< y, luminance first
  const Image1* variance;      ///< of the luminance of single samples, in the history; >= 0
  const Image1* inverse_depth;
};

/// MeasureSamples: luminance of `measured` = squared difference of x and y, red = SampleNoise of x,
/// variance = 0; valid = 1 for pixels of several samples on surfaces. KeepSamples: blends x into y,
/// also for keep_mirrors.
/// \param reach  KeepSamplesParameters::kept_reach
/// \param blurred  `measured` after the wavelet levels; not read where `valid` is 0
namespace reference {
void MeasureSamples(const KeepSamplesInput& in, FilterPlanes* measured, Image1* valid);
void KeepSamples(const FilterPlanes& blurred, const Image1& valid, const NewLight& light,
                 float reach, LumaImage3* filtered);
}  // namespace reference
namespace cpu {
void MeasureSamples(const KeepSamplesInput& in, FilterPlanes* measured, Image1* valid);
void KeepSamples(const FilterPlanes& blurred, const Image1& valid, const NewLight& light,
                 float reach, LumaImage3* filtered);
}  // namespace cpu

}  // namespace stillray
