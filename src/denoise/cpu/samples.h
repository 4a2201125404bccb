// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "denoise/cpu/frame_work.h"
#include "denoise/cpu/pipeline.h"

namespace stillray {

/// Runs keep_samples and its wavelet levels on all signals whose samples have a known variance.
void RunKeepSamples(const CpuPipeline& p, const GuidePlanes& guides, LayerWork* work,
                    DenoisedFrame* out);

/// Runs the levels of keep_samples or keep_mirrors, and the blend.
/// \param measured  output of MeasureSamples or MeasureMirrors; overwritten, as is \p other (work
///     memory)
void BlendSamples(const CpuPipeline& p, const GuidePlanes& guides, const NewLight& light,
                  const Image1& valid, FilterPlanes* measured, FilterPlanes* other,
                  LumaImage3* filtered);

}  // namespace stillray
