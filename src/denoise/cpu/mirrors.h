// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "denoise/cpu/pipeline.h"
#include "denoise/cpu/signals.h"

namespace stillray {

/// keep_mirrors and its wavelet levels: restores samples of mirrors that the filter made worse, in
/// WaveletPlanes::light.
void RunKeepMirrors(const CpuPipeline& p, const FrameInput& in, const GuidePlanes& guides,
                    LayerWork* work, DenoisedFrame* out);

}  // namespace stillray
