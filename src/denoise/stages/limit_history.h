// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// limit_history: where the light itself changed, history that no longer resembles the present
/// counts less. PSVGF (section 7) names the cure and gives no formula; ours: luminance of present
/// and history, compressed, is blurred by three geometry-only wavelet levels; what their difference
/// exceeds its expected noise by is taken for bias, and a Kalman gain says how many samples such a
/// history is still worth. State: none. Border: that of the wavelet.
#pragma once

#include "denoise/planes.h"

namespace stillray {

/// The level functions around the wavelet, which the denoiser calls in between.
/// Compare: colour = (compressed present, compressed history, 0), variance = expected noise of
/// their difference, zero where either is missing; present = 1 where both exist. Limit: length that
/// the history may count for; large where nothing speaks against it.
struct LimitHistoryParameters {
  float mean = 1;  ///< mean luminance of the signal (of the history; of the frame at the start)
  float dead = 8;
  float gain = 16;
  bool rec601 = false;
};

namespace reference {
void CompareWithHistory(const NewLight& light, const SignalHistory& before,
                        const GuidePlanes& guides, const LimitHistoryParameters& parameters,
                        FilterPlanes* compared, Image1* present);
void LimitHistory(const FilterPlanes& blurred, const Image1& present, const NewLight& light,
                  const SignalHistory& before, const LimitHistoryParameters& parameters,
                  Image1* limit);
}  // namespace reference
namespace cpu {
void CompareWithHistory(const NewLight& light, const SignalHistory& before,
                        const GuidePlanes& guides, const LimitHistoryParameters& parameters,
                        FilterPlanes* compared, Image1* present);
void LimitHistory(const FilterPlanes& blurred, const Image1& present, const NewLight& light,
                  const SignalHistory& before, const LimitHistoryParameters& parameters,
                  Image1* limit);
}  // namespace cpu

}  // namespace stillray
