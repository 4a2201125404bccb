// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// clip_outliers: a pixel of the filtered light whose luminance is outside the range of its eight
/// neighbours becomes the mean of their light, scaled to the nearest value of that range. Removes
/// the specks that remain where the wavelet refuses all neighbours: on thin and on curved surfaces,
/// in first frames. Only an excess that the variance of the filtered light explains is noise: a
/// bright point that has enough samples stays, and a still view converges to it.
/// Source: none; a conservative smoothing filter (Jain 1989) with a test of significance.
/// No state. Border: 1 pixel of light and of `where`. Reads 12 bytes per pixel and signal.
#pragma once

#include "denoise/planes.h"
#include "denoise/stages/clip_outliers_shared.h"

namespace stillray {

struct ClipOutliersInput {
  const Image1* variance;  ///< of the light's luminance
  const Image1* where;     ///< positive where there is light; 0 in its border
  /// GuidePlanes::full if every surface has light: `where` is then read at edges only. nullptr:
  /// unknown.
  const Plane<uint32_t>* full = nullptr;
};

/// \param scratch  overwritten; its variance may be that of `in`
/// \param light    luminance first, changed in place
namespace reference {
void ClipOutliers(const ClipOutliersInput& in, const ClipOutliersParameters& parameters,
                  FilterPlanes* scratch, LumaImage3* light);
}  // namespace reference
namespace cpu {
void ClipOutliers(const ClipOutliersInput& in, const ClipOutliersParameters& parameters,
                  FilterPlanes* scratch, LumaImage3* light);
}  // namespace cpu

}  // namespace stillray
