// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "denoise/cpu/pipeline.h"
#include "denoise/cpu/signals.h"

namespace stillray {

/// Runs keep_mirrors and its wavelet levels on WaveletPlanes::light.
void RunKeepMirrors(const CpuPipeline& p, const FrameInput& in, const GuidePlanes& guides,
                    LayerWork* work, DenoisedFrame* out);

}  // namespace stillray
