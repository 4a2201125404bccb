// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The stages that run for each signal separately: from its radiance to its history.
#pragma once

#include "denoise/cpu/outputs.h"
#include "denoise/cpu/pipeline.h"

namespace stillray {

/// The input of the stages. Guides, emission and background may be the output of fill_guides.
struct FrameInput {
  const Frame& frame;
  const Guides& guides;   ///< of the layer
  const Guides& surface;  ///< guides with the albedos by which second moments are divided
  const Image3& emission;
  const Image3& background;
  const Image1& roughness;        ///< empty if unknown
  const Image3& previous_normal;  ///< empty if unknown
  float negative_limit = 0;       ///< values in (-negative_limit, 0) become zero
};

/// The albedos that a signal is divided by.
AlbedoSum AlbedosOf(const DemodulateParameters& p, const SignalGroup& signal, const Guides& guides);

/// Runs demodulate and suppress_fireflies; the output is LayerWork::light. Also chooses the
/// compression scale of the signal, if its history has compressed luminances.
void GatherLight(const CpuPipeline& p, const FrameInput& in, size_t signal, LayerHistory* history,
                 LayerWork* work, FrameOutputs* outputs, DenoisedFrame* out);

/// Runs correct_history and limit_history; the output is the bias of each signal's history, in
/// WaveletPlanes::luminance_factor, and WaveletPlanes::ratio.
void RunLimitHistory(const CpuPipeline& p, const FrameInput& in, const LayerHistory& history,
                     LayerWork* work, FrameOutputs* outputs, DenoisedFrame* out);

/// Accumulates the new samples of a signal into its history.
void RunAccumulate(const CpuPipeline& p, size_t signal, LayerHistory* history, LayerWork* work,
                   DenoisedFrame* out);

/// Stores the output "alpha", the weight of the new frame; called after RunAccumulate.
void KeepAlpha(const CpuPipeline& p, size_t signal, const LayerHistory& history,
               const LayerWork& work, FrameOutputs* outputs);

/// \return the history of a signal merged with its future, in LayerWork::merged
SignalHistory* RunMergeFuture(const CpuPipeline& p, size_t signal, const SignalHistory& history,
                              const SignalHistory& future, LayerWork* work, DenoisedFrame* out);

/// The reprojected history at this frame's pixels, with lengths and weights limited by
/// limit_history; called before accumulate.
SignalHistory ShortenedHistory(const CpuPipeline& p, size_t signal, const LayerHistory& history,
                               const LayerWork& work);

}  // namespace stillray
