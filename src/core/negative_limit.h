// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Light that is negative within rounding is zero; light that is negative beyond it is missing.
/// Renderers, sums of passes and lossy files leave -1e-6 where there is no light: were that
/// missing, only the bright samples of a noisy picture would be left, and the picture too bright.
/// The limit is 1/1024 of the frame's mean light, so it follows the exposure. The mean is that of
/// the brightest component of all signals at a lattice of pixels, by powers of two, in which the
/// seven brightest pixels (fewer of less than 448) count no more than the eighth: no firefly
/// raises the limit. All sums are of integers, so that threads and devices agree.
#pragma once

#include "stillray/frame.h"

namespace stillray {

/// Every so many columns and rows are measured.
/// \param sparse  few pixels have a sample: none of those may be passed over
inline int MeasureStride(int width, int height, bool sparse) {
  constexpr int64_t kMeasuredWhole = 65536;
  return sparse || int64_t{width} * height < kMeasuredWhole ? 1 : 4;
}

/// How far below zero light of this frame may lie and still be zero; 0 for a black frame.
float NegativeLimitOf(const Frame& frame, bool sparse);
/// The same of one layer of light.
float NegativeLimitOf(const Image3& light);

}  // namespace stillray
