// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The limit between negative light that is rounding, and counts as zero, and negative light that
/// is missing. Renderers, sums of passes and lossy files leave -1e-6 where there is no light. If
/// those samples were missing, only the bright samples of a noisy picture would remain, and it
/// would be too bright. The limit is 1/1024 of the frame's mean light, so it follows the exposure.
/// The mean is taken over the brightest component of all signals on a grid of pixels, quantised to
/// powers of two; the seven brightest pixels (fewer if less than 448 are measured) count as much as
/// the eighth, so that no firefly raises the limit. All sums are of integers, so that threads and
/// devices agree.
#pragma once

#include "stillray/frame.h"

namespace stillray {

/// Distance of the measured columns and rows.
/// \param sparse  few pixels have a sample, so all are measured
inline int MeasureStride(int width, int height, bool sparse) {
  constexpr int64_t kMeasuredWhole = 65536;
  return sparse || int64_t{width} * height < kMeasuredWhole ? 1 : 4;
}

/// How far below zero light of this frame still counts as zero; 0 for a black frame.
float NegativeLimitOf(const Frame& frame, bool sparse);
/// The same for one layer of light.
float NegativeLimitOf(const Image3& light);

}  // namespace stillray
