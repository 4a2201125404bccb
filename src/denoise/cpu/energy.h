// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// restore_energy in the pipeline.
#pragma once

#include "denoise/cpu/frame_work.h"
#include "denoise/cpu/pipeline.h"

namespace stillray {

/// Gives the filtered light, WaveletPlanes::light, the brightness of the light before the wavelet.
void RunRestoreEnergy(const CpuPipeline& p, const GuidePlanes& guides, LayerWork* work,
                      DenoisedFrame* out);

}  // namespace stillray
