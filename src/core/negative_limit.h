// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The limit between negative radiance due to rounding, which counts as zero, and negative radiance
/// that is treated as missing. Renderers, sums of passes and lossy files yield values like -1e-6 in
/// black regions. If these samples were missing, only the bright samples of a noisy image would
/// remain, and the result would be too bright. The limit is 1/1024 of the frame's mean radiance, so
/// it scales with the exposure. The mean is taken over the brightest component of all signals on a
/// grid of pixels, quantised to powers of two; the seven brightest pixels (fewer if less than 448
/// are measured) count as much as the eighth, so that no firefly raises the limit. All sums are of
/// integers, so that threads and devices agree.
#pragma once

#include "stillray/frame.h"

namespace stillray {

/// Spacing of the measured columns and rows.
/// \param sparse  few pixels have a sample, so all pixels are measured
inline int MeasureStride(int width, int height, bool sparse) {
  constexpr int64_t kMeasuredWhole = 65536;
  return sparse || int64_t{width} * height < kMeasuredWhole ? 1 : 4;
}

/// Magnitude of negative radiance that counts as zero in this frame; 0 for a black frame.
float NegativeLimitOf(const Frame& frame, bool sparse);
/// As above, for one layer of radiance.
float NegativeLimitOf(const Image3& light);

}  // namespace stillray
