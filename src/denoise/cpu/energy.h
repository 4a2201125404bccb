// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// restore_energy in the pipeline.
#pragma once

#include "denoise/cpu/frame_work.h"
#include "denoise/cpu/pipeline.h"

namespace stillray {

/// Before the wavelet: measures the light that it filters.
void RunBeginEnergy(const CpuPipeline& p, const GuidePlanes& guides, LayerWork* work,
                    DenoisedFrame* out);

/// After the wavelet: gives WaveletPlanes::light the brightness that was measured.
void RunRestoreEnergy(const CpuPipeline& p, const GuidePlanes& guides, LayerWork* work,
                      DenoisedFrame* out);

}  // namespace stillray
