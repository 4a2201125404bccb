// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// From the histories of all signals to the filtered signals.
#pragma once

#include "denoise/cpu/outputs.h"
#include "denoise/cpu/pipeline.h"
#include "denoise/cpu/signals.h"

namespace stillray {

/// Sets \p history as the input of a signal's wavelet.
void BeginFilter(const CpuPipeline& p, const FrameInput& in, size_t signal, SignalHistory* history,
                 LayerWork* work, FrameOutputs* outputs);

/// Runs estimate_variance and all wavelet levels; the output of the feedback level is stored in the
/// history. The result is WaveletPlanes::light.
void RunWavelet(const CpuPipeline& p, const FrameInput& in, const GuidePlanes& guides,
                LayerWork* work, FrameOutputs* outputs, DenoisedFrame* out);

/// WaveletPlanes::light for modification: copied first if it is a plane of the history.
LumaImage3* ChangeableLight(WaveletPlanes* planes);

}  // namespace stillray
