// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// accumulate: blends this frame's light and moments into the reprojected history. Source: SVGF
/// section 4.1 (eq. 1), section 4.2; PSVGF section 4.2. Departs from them: moments in deviation
/// form; age counts samples, with the moments within a pixel of several samples added; a missing
/// pixel changes nothing; the sum of squared weights is stored; a confidence in the history, where
/// the caller gives one, shortens it (stages/reproject.h) and raises alpha_min and alpha_moments,
/// which would else keep it long. Pixel by pixel, in place allowed unless the history is fetched
/// along taps. Reads 44, writes 28 bytes, and 4 more of each for the variance.
#pragma once

#include "denoise/planes.h"
#include "denoise/stages/accumulate_shared.h"
#include "denoise/stages/reproject_shared.h"

namespace stillray {

/// The weight that accumulate has given to the new frame at a pixel.
/// \param length      of the history after it
/// \param n           samples of the new frame
/// \param confidence  in the history: UsedConfidence
inline float UsedAlpha(const AccumulateParameters& p, float length, float n, float confidence) {
  return NewFrameWeight(length - n, n, ConfidentAlpha(p.alpha_min, confidence),
                        p.history_weight_constant != 0);
}

/// What limit_history found out about a history.
struct HistoryLimits {
  const Image1* bias = nullptr;   ///< relative, see LimitedLength; nullptr: 0
  const Image1* ratio = nullptr;  ///< factor of its light; given where the bias is
  float gain = 0;                 ///< of LimitedLength
};

/// \param before  reprojected history (all zero: none), or with taps that of the last frame, which
///     is fetched along them (stages/reproject.h) and must not be \p out
/// \param taps    nullptr: the history is already fetched
/// \param out     its `compressed_scale` is set; 0: `compressed` is left out
namespace reference {
void Accumulate(const NewLight& light, const SignalHistory& before, const ReprojectionTaps* taps,
                const HistoryLimits& limits, const AccumulateParameters& parameters,
                SignalHistory* out);
}  // namespace reference
namespace cpu {
void Accumulate(const NewLight& light, const SignalHistory& before, const ReprojectionTaps* taps,
                const HistoryLimits& limits, const AccumulateParameters& parameters,
                SignalHistory* out);
}  // namespace cpu

}  // namespace stillray
