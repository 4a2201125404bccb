// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Fused stages of the CPU. Each is bit-identical to the separate stages, so the scalar reference
/// has no fused ones. Measured with the preset `default`, one thread of an AMD EPYC, 1280x720,
/// alternating with the separate stages:
///
/// | | instead of | time of the frame |
/// |---|---|---|
/// | cpu::PrepareAndFindTaps | prepare_guides, reproject | 0.99 |
/// | cpu::AntialiasParts | remodulate, antialias | 0.99 (svgf: 0.97) |
/// | cpu::AccumulateInPlace | accumulate into other planes | 0.93 of a static, sparse view |
/// | AtrousSignal::mixed_length | the pilot's level, mix_pilot | 0.97 (two threads) |
#pragma once

#include "denoise/plan.h"
#include "denoise/planes.h"
#include "denoise/stages/accumulate.h"
#include "denoise/stages/antialias.h"
#include "denoise/stages/prepare_guides.h"
#include "denoise/stages/remodulate.h"

namespace stillray {

/// The fused stages of a frame.
struct Fusion {
  bool prepare_and_find_taps = false;
  bool accumulate_in_place = false;
  bool antialias_parts = false;
  bool mix_pilot = false;  ///< fused with the preceding level, if every surface has samples
};

/// \param keeps_outputs  the caller requests intermediate images
Fusion ChooseFusion(const FramePlan& plan, bool keeps_outputs);

/// Whether the history is updated in place, since few of its taps are at other pixels.
bool ChangesInPlace(const Fusion& fusion, const ReprojectionTaps& taps,
                    const StagedHistory& staged);

namespace cpu {
/// prepare_guides, with FindTaps (stages/reproject.h) for each row as soon as its guides are
/// computed.
/// \return the count of PrepareGuides
int64_t PrepareAndFindTaps(const PrepareGuidesInput& in, const GuidePlanes& before,
                           const Image2& motion, const ReprojectParameters& parameters,
                           GuidePlanes* out, ReprojectionTaps* taps);

/// accumulate into \p history itself, fetched along \p taps; writes only pixels that change.
/// \param lit_alone  pixels without samples so far have no radiance in the history either, since
///     nothing was fed back to them
/// \param staged     work memory with capacity for all vectors that gather
void AccumulateInPlace(const NewLight& light, const ReprojectionTaps& taps,
                       const HistoryLimits& limits, const AccumulateParameters& parameters,
                       bool lit_alone, StagedHistory* staged, SignalHistory* history);

/// remodulate and antialias, without storing the image between them.
/// \return the count of Remodulate
int64_t AntialiasParts(const PictureParts& parts, const AntialiasInput& in,
                       const AntialiasParameters& parameters, Image3* out);
}  // namespace cpu

}  // namespace stillray
