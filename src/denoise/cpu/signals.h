// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The stages that run for each signal separately: from its light to its history.
#pragma once

#include "denoise/cpu/outputs.h"
#include "denoise/cpu/pipeline.h"

namespace stillray {

/// The input of the stages. Guides, emission and background may be completed ones.
struct FrameInput {
  const Frame& frame;
  const Guides& guides;   ///< of the layer
  const Guides& surface;  ///< whose albedos second moments are divided by
  const Image3& emission;
  const Image3& background;
  const Image1& roughness;        ///< empty if unknown
  const Image3& previous_normal;  ///< likewise
  float negative_limit = 0;       ///< negative light above -negative_limit is zero
};

/// The albedos that a signal is divided by.
AlbedoSum AlbedosOf(const DemodulateParameters& p, const SignalGroup& signal, const Guides& guides);

/// demodulate and suppress_fireflies: the new light of a signal, in LayerWork::light. Also chooses
/// its compression scale, if its history has compressed luminances.
void GatherLight(const CpuPipeline& p, const FrameInput& in, size_t signal, LayerHistory* history,
                 LayerWork* work, FrameOutputs* outputs, DenoisedFrame* out);

/// The largest length that each signal's history may count for, in WaveletPlanes::luminance_factor.
void RunLimitHistory(const CpuPipeline& p, const FrameInput& in, const LayerHistory& history,
                     LayerWork* work, FrameOutputs* outputs, DenoisedFrame* out);

/// Accumulates the new light of a signal in its history.
void RunAccumulate(const CpuPipeline& p, size_t signal, LayerHistory* history, LayerWork* work,
                   DenoisedFrame* out);

/// The output "alpha": the weight of the new frame, after RunAccumulate.
void KeepAlpha(const CpuPipeline& p, size_t signal, const LayerHistory& history,
               const LayerWork& work, FrameOutputs* outputs);

/// \return the history of a signal with the light of its future, in LayerWork::merged
SignalHistory* RunMergeFuture(const CpuPipeline& p, size_t signal, const SignalHistory& history,
                              const SignalHistory& future, LayerWork* work, DenoisedFrame* out);

/// The history of this frame's pixels with the lengths and weights that limit_history allows;
/// called before accumulate.
SignalHistory ShortenedHistory(const CpuPipeline& p, size_t signal, const LayerHistory& history,
                               const LayerWork& work);

}  // namespace stillray
