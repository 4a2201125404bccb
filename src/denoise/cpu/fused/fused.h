// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Stages of the CPU that run together because that is faster. Each leaves the very bits of its
/// stages one after the other, so the scalar reference has none of them. Measured with the preset
/// `default`, one thread of an AMD EPYC, 1280x720, in turns with the stages apart:
///
/// | | instead of | time of the frame |
/// |---|---|---|
/// | cpu::PrepareAndFindTaps | prepare_guides, reproject | 0.99 |
/// | cpu::AntialiasParts | remodulate, antialias | 0.99 (svgf: 0.97) |
/// | cpu::AccumulateInPlace | accumulate into other planes | 0.93 of a still, sparse view |
#pragma once

#include "denoise/plan.h"
#include "denoise/planes.h"
#include "denoise/stages/antialias.h"
#include "denoise/stages/prepare_guides.h"
#include "denoise/stages/remodulate.h"

namespace stillray {

/// Which stages of a frame run together.
struct Fusion {
  bool prepare_and_find_taps = false;
  bool accumulate_in_place = false;
  bool antialias_parts = false;
};

/// \param keeps_outputs  the caller wants intermediate pictures
Fusion ChooseFusion(const FramePlan& plan, bool keeps_outputs);

/// Whether so little of the history lies at other pixels that it is changed in place.
bool ChangesInPlace(const Fusion& fusion, const ReprojectionTaps& taps,
                    const StagedHistory& staged);

namespace cpu {
/// prepare_guides, and the taps of each row (stages/reproject.h) as soon as its guides are known.
/// \return that of PrepareGuides
int64_t PrepareAndFindTaps(const PrepareGuidesInput& in, const GuidePlanes& before,
                           const Image2& motion, const ReprojectParameters& parameters,
                           GuidePlanes* out, ReprojectionTaps* taps);

/// accumulate into \p history itself, looked up along \p taps; touches no pixel that stays as it
/// is.
/// \param limit      length that the history may count for at most, or nullptr
/// \param lit_alone  pixels without samples so far have no light in the history either: none was
///                   fed back to them
/// \param staged     with room for all vectors that read history elsewhere
void AccumulateInPlace(const NewLight& light, const ReprojectionTaps& taps, const Image1* limit,
                       const AccumulateParameters& parameters, bool lit_alone,
                       StagedHistory* staged, SignalHistory* history);

/// remodulate and antialias: the picture before antialiasing is kept nowhere.
/// \return that of Remodulate
int64_t AntialiasParts(const PictureParts& parts, const AntialiasInput& in,
                       const AntialiasParameters& parameters, Image3* out);
}  // namespace cpu

}  // namespace stillray
