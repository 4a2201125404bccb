// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// limit_history: history rejection where the light itself has changed. PSVGF (section 7) proposes
/// it without a formula. Here the compressed luminance of this frame's samples is compared with the
/// mean of the compressed luminances of earlier ones, both blurred by three geometry-only wavelet
/// levels; the excess of their squared difference over its expected noise is an estimate of the
/// squared bias, from which a Kalman gain determines the number of samples that such a history is
/// worth. The history holds the mean of compressed samples, not the compressed mean: a mean of few
/// bright samples compresses to a higher value than the mean of the compressed samples, so that
/// sparse light would always seem to change. Border: that of the wavelet. Reads 80, writes 20 bytes
/// per pixel and signal around the wavelet.
#pragma once

#include "denoise/planes.h"
#include "denoise/stages/limit_history_shared.h"

namespace stillray {

/// Number of wavelet levels between them: with larger kernels, or one level more, changes of the
/// light are detected later than lower noise would compensate.
inline constexpr int kLimitHistoryLevels = 3;

/// Converts the compressed luminances of a history to another scale.
void RescaleHistory(float scale, SignalHistory* history);

/// CompareWithHistory and LimitHistory run before and after the wavelet levels, for each signal.
/// CompareWithHistory: luminance = compressed present minus compressed history, red = variance of
/// single compressed samples, variance = expected noise of the difference; valid = 1 where both
/// exist. LimitHistory: the largest length that the history may count for; its own length without
/// bias. The history is that of the last frame, fetched along `taps`.
namespace reference {
void CompareWithHistory(const NewLight& light, const SignalHistory& before,
                        const ReprojectionTaps& taps, const GuidePlanes& guides,
                        FilterPlanes* compared, Image1* valid);
void LimitHistory(const FilterPlanes& blurred, const Image1& valid, const SignalHistory& before,
                  const ReprojectionTaps& taps, const LimitHistoryParameters& parameters,
                  Image1* limit);
}  // namespace reference
namespace cpu {
void CompareWithHistory(const NewLight& light, const SignalHistory& before,
                        const ReprojectionTaps& taps, const GuidePlanes& guides,
                        FilterPlanes* compared, Image1* valid);
void LimitHistory(const FilterPlanes& blurred, const Image1& valid, const SignalHistory& before,
                  const ReprojectionTaps& taps, const LimitHistoryParameters& parameters,
                  Image1* limit);
}  // namespace cpu

}  // namespace stillray
