// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// keep_samples: pixels of several samples keep them where their noise is smaller than the error of
/// the filter. The wavelet removes detail of light that it cannot tell from noise, and the history
/// blurs it; what is removed does not become less with the number of samples, while their noise
/// does: above some number the noisy picture would be better than the filtered one. The filtered
/// light y is blended with this frame's light x. Source: James and Stein 1961; Green and
/// Strawderman 1991, "A James-Stein type estimator for combining unbiased and possibly biased
/// estimators": the squared bias of y is the excess of the mean of (x - y)^2 over the variance of
/// x. Both are means of three geometry-only wavelet levels. The variance is known from the samples
/// within pixels and from the history, of which the larger counts: rare bright samples are missing
/// in most frames. As the noise goes to zero the result goes to x, so that it converges to the
/// reference. Where the variance within pixels is estimated from those around (frames of other
/// renderers), a pixel's deviation x - y is limited (ShareOfFiltered): means hide a rare bright
/// sample, and single pixels would come back as specks. Pixels of one sample are unchanged, bit for
/// bit. Departs from SVGF, which has no such stage. No state. Border: that of these levels. Reads
/// 44, writes 28 bytes per pixel and signal around the wavelet.
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
/// variance = 0; valid = 1 for pixels of several samples on surfaces. KeepSamples: blends x into y;
/// keep_mirrors does so too.
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
