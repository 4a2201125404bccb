// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// limit_history: where the light itself changed, history that no longer resembles the present
/// counts less. PSVGF (section 7) names the cure and gives no formula; ours: the compressed
/// luminance of this frame's samples is compared with the mean of the compressed luminances of
/// earlier ones, both blurred by three geometry-only wavelet levels; what their difference exceeds
/// its expected noise by is taken for bias, and a Kalman gain says how many samples such a history
/// is still worth. The history keeps the mean of compressed samples, not the compressed mean: a
/// mean of few bright samples compresses to more than they do one by one, so that sparse light
/// would always look changed. Border: that of the wavelet. Reads 80, writes 20 bytes per pixel
/// and signal around the wavelet.
#pragma once

#include "denoise/planes.h"
#include "denoise/stages/limit_history_shared.h"

namespace stillray {

/// The wavelet between them: larger kernels, or one level more, see changes of the light later than
/// they make up for by less noise.
inline constexpr int kLimitHistoryLevels = 3;

/// Brings the compressed luminances of a history to another scale.
void RescaleHistory(float scale, SignalHistory* history);

/// CompareWithHistory and LimitHistory run before and after the wavelet, for each signal.
/// CompareWithHistory: luminance = compressed present less compressed history, red = variance of
/// single compressed samples, variance = expected noise of the difference; present = 1 where both
/// exist. LimitHistory: the length that the history may count for; its own where no bias is found.
/// The history is that of the last frame, looked up along `taps`.
namespace reference {
void CompareWithHistory(const NewLight& light, const SignalHistory& before,
                        const ReprojectionTaps& taps, const GuidePlanes& guides,
                        FilterPlanes* compared, Image1* present);
void LimitHistory(const FilterPlanes& blurred, const Image1& present, const SignalHistory& before,
                  const ReprojectionTaps& taps, const LimitHistoryParameters& parameters,
                  Image1* limit);
}  // namespace reference
namespace cpu {
void CompareWithHistory(const NewLight& light, const SignalHistory& before,
                        const ReprojectionTaps& taps, const GuidePlanes& guides,
                        FilterPlanes* compared, Image1* present);
void LimitHistory(const FilterPlanes& blurred, const Image1& present, const SignalHistory& before,
                  const ReprojectionTaps& taps, const LimitHistoryParameters& parameters,
                  Image1* limit);
}  // namespace cpu

}  // namespace stillray
