// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// clip_outliers: a pixel of the filtered signal whose luminance is outside the range of its eight
/// neighbours is replaced by the mean of the neighbours, scaled to the nearest value of that range.
/// Removes the specks that remain where all neighbours have weights near zero: on thin and on
/// curved surfaces, in first frames. An excess counts as noise only if the variance of the filtered
/// signal explains it: a bright point with enough samples stays, and a static view converges to it.
/// Source: none; a conservative smoothing filter (Jain 1989) with a test of significance. No state.
/// Border: 1 pixel of the signal and of `where`. Reads 12 bytes per pixel and signal.
#pragma once

#include "denoise/planes.h"
#include "denoise/stages/clip_outliers_shared.h"

namespace stillray {

struct ClipOutliersInput {
  const Image1* variance;  ///< of the luminance of the filtered signal
  const Image1* where;     ///< positive for pixels with samples; 0 in its border
  /// GuidePlanes::full if every surface has samples: `where` is then read at edges only. nullptr:
  /// unknown.
  const Plane<uint32_t>* full = nullptr;
};

/// \param scratch  overwritten; its variance plane may be `in.variance`
/// \param light    [in,out] the filtered signal; its first plane is luminance
namespace reference {
void ClipOutliers(const ClipOutliersInput& in, const ClipOutliersParameters& parameters,
                  FilterPlanes* scratch, LumaImage3* light);
}  // namespace reference
namespace cpu {
void ClipOutliers(const ClipOutliersInput& in, const ClipOutliersParameters& parameters,
                  FilterPlanes* scratch, LumaImage3* light);
}  // namespace cpu

}  // namespace stillray
