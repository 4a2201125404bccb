// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// accumulate: blends this frame's signal and moments into the reprojected history. Source: SVGF
/// section 4.1 (eq. 1), section 4.2; PSVGF section 4.2. Departs from them: moments in deviation
/// form; age counts samples, with the moments within a pixel of several samples added; a missing
/// pixel changes nothing; the sum of squared weights is stored; if the caller gives a confidence in
/// the history, it shortens the history (stages/reproject.h) and raises alpha_min and
/// alpha_moments, which would otherwise keep the history long. Pixel by pixel, in place allowed
/// unless the history is fetched along taps. Per pixel reads 44 and writes 28 bytes; with the
/// variance 4 more of each.
#pragma once

#include "denoise/planes.h"
#include "denoise/stages/accumulate_shared.h"
#include "denoise/stages/reproject_shared.h"

namespace stillray {

/// The weight of the new frame in the history of a pixel, as accumulate computes it.
/// \param length      history length in samples, the new frame included
/// \param n           samples of the new frame
/// \param confidence  UsedConfidence, the confidence in the history
inline float UsedAlpha(const AccumulateParameters& p, float length, float n, float confidence) {
  return NewFrameWeight(length - n, n, ConfidentAlpha(p.alpha_min, confidence),
                        p.history_weight_constant != 0);
}

/// The results of limit_history for a history.
struct HistoryLimits {
  const Image1* bias = nullptr;   ///< relative, see LimitedLength; nullptr: 0
  const Image1* ratio = nullptr;  ///< factor of its radiance; nullptr if `bias` is
  float gain = 0;                 ///< parameter of LimitedLength
};

/// \param before  reprojected history (all zero: none); with \p taps the history of the last frame,
///     which is fetched along the taps (stages/reproject.h) and must not be \p out
/// \param taps    nullptr: the history is already fetched
/// \param out     [out] `compressed_scale` is an input; if it is 0, `compressed` is not written
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
