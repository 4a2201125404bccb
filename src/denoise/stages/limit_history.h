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
inline constexpr int kLimitHistoryRadius = 1;

/// The functions around the wavelet, which the denoiser calls in between, for all signals at once.
/// Compare: luminance = compressed present less compressed history, red = variance of single
/// compressed samples, variance = expected noise of the difference; present = 1 where both
/// exist. Limit: length that the history may count for; its own where nothing speaks against it.
/// The history is that of the last frame, looked up along `taps`.
struct LimitHistoryParameters {
  float scale = 1;  ///< luminance that is compressed to 1/2; that of `before.compressed`
  float dead = 8;
  float gain = 16;
};

/// Brings the compressed luminances of a history to another scale.
void RescaleHistory(float scale, SignalHistory* history);

namespace reference {
void CompareWithHistory(const NewLight& light, const SignalHistory& before,
                        const ReprojectionTaps& taps, const GuidePlanes& guides,
                        const LimitHistoryParameters& parameters, FilterPlanes* compared,
                        Image1* present);
void LimitHistory(const FilterPlanes& blurred, const Image1& present, const SignalHistory& before,
                  const ReprojectionTaps& taps, const LimitHistoryParameters& parameters,
                  Image1* limit);
}  // namespace reference
namespace cpu {
void CompareWithHistory(const NewLight& light, const SignalHistory& before,
                        const ReprojectionTaps& taps, const GuidePlanes& guides,
                        const LimitHistoryParameters& parameters, FilterPlanes* compared,
                        Image1* present);
void LimitHistory(const FilterPlanes& blurred, const Image1& present, const SignalHistory& before,
                  const ReprojectionTaps& taps, const LimitHistoryParameters& parameters,
                  Image1* limit);
}  // namespace cpu

}  // namespace stillray
