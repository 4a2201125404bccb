// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// From the histories of all signals to their filtered light.
#pragma once

#include "denoise/cpu/outputs.h"
#include "denoise/cpu/pipeline.h"
#include "denoise/cpu/signals.h"

namespace stillray {

/// Sets the input of a signal's wavelet to this history.
void BeginFilter(const CpuPipeline& p, const FrameInput& in, size_t signal, SignalHistory* history,
                 LayerWork* work, FrameOutputs* outputs);

/// estimate_variance and all levels; the output of the feedback level becomes history. The result
/// is WaveletPlanes::light.
void RunWavelet(const CpuPipeline& p, const FrameInput& in, const GuidePlanes& guides,
                LayerWork* work, FrameOutputs* outputs, DenoisedFrame* out);

/// The light of a signal, copied first if it is also the history.
LumaImage3* ChangeableLight(WaveletPlanes* planes);

}  // namespace stillray
