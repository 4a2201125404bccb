// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// accumulate: blends this frame's light and moments into the reprojected history.
/// Source: SVGF section 4.1 (eq. 1), section 4.2; PSVGF section 4.2. Departs from them: moments in
/// deviation form; age counts samples, with the moments within a pixel of several samples added; a
/// missing pixel changes nothing; the sum of squared weights is kept. Pixel by pixel, in place
/// allowed unless the history is looked up on the way. Reads 44, writes 28 bytes, and 4 more of
/// each where the variance is wanted.
#pragma once

#include "denoise/planes.h"
#include "denoise/stages/demodulate.h"
#include "denoise/stages/estimate_variance.h"

namespace stillray {

struct AccumulateParameters {
  float alpha_min = 0.1f;
  float alpha_moments = 0.1f;
  bool constant_weight = false;  ///< SVGF: alpha_min wherever there is history
  int max_history = 0;           ///< samples; 0: no limit
  /// Luminance that is compressed to 1/2 in `compressed`; 0: that plane is left out.
  float compressed_scale = 0;
  /// Pixels without samples so far have no light in the history either: none was fed back to them.
  bool lit_alone = false;
};

/// \param before  reprojected history (all zero: none), or with taps that of the last frame, which
///                is looked up along them (stages/reproject.h) and must not be \p out
/// \param taps    nullptr: the history has been looked up
/// \param limit   length that the history may count for at most, or nullptr
/// AccumulateInPlace does the same to \p history itself, and touches no pixel that stays as it is:
/// for views in which little moves.
/// \param staged  with room for all vectors that are kElsewhere
/// AccumulateRadiance divides the light by its albedo on the way (stages/demodulate.h): the colour
/// of \p light says nothing then, nor do its samples unless the frame has some.
/// \param variance  wanted of the new history (stages/estimate_variance.h), or nullptr
namespace reference {
void AccumulateInPlace(const NewLight& light, const ReprojectionTaps& taps, const Image1* limit,
                       const AccumulateParameters& parameters, StagedHistory* staged,
                       SignalHistory* history);
void Accumulate(const NewLight& light, const SignalHistory& before, const ReprojectionTaps* taps,
                const Image1* limit, const AccumulateParameters& parameters, SignalHistory* out);
DemodulateCounts AccumulateRadiance(const DemodulateInput& radiance, const SignalHistory& before,
                                    const ReprojectionTaps& taps,
                                    const AccumulateParameters& parameters, NewLight* light,
                                    VarianceOnTheWay* variance, SignalHistory* out);
}  // namespace reference
namespace cpu {
void AccumulateInPlace(const NewLight& light, const ReprojectionTaps& taps, const Image1* limit,
                       const AccumulateParameters& parameters, StagedHistory* staged,
                       SignalHistory* history);
void Accumulate(const NewLight& light, const SignalHistory& before, const ReprojectionTaps* taps,
                const Image1* limit, const AccumulateParameters& parameters, SignalHistory* out);
DemodulateCounts AccumulateRadiance(const DemodulateInput& radiance, const SignalHistory& before,
                                    const ReprojectionTaps& taps,
                                    const AccumulateParameters& parameters, NewLight* light,
                                    VarianceOnTheWay* variance, SignalHistory* out);
}  // namespace cpu

}  // namespace stillray
