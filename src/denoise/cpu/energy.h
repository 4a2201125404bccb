// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// restore_energy in the pipeline.
#pragma once

#include "denoise/cpu/frame_work.h"
#include "denoise/cpu/pipeline.h"

namespace stillray {

/// Runs restore_energy and its levels on the filtered signals (WaveletPlanes::light).
void RunRestoreEnergy(const CpuPipeline& p, const FrameInput& in, const GuidePlanes& guides,
                      LayerWork* work, DenoisedFrame* out);

}  // namespace stillray
