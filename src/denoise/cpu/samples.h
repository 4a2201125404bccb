// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "denoise/cpu/frame_work.h"
#include "denoise/cpu/pipeline.h"

namespace stillray {

/// keep_samples and its wavelet levels, in all signals whose samples have a known variance.
void RunKeepSamples(const CpuPipeline& p, const GuidePlanes& guides, LayerWork* work,
                    DenoisedFrame* out);

/// The levels of keep_samples and keep_mirrors, and the blend.
/// \param measured  squared differences and noise, of one of the two; overwritten, as `other` is
void BlendSamples(const CpuPipeline& p, const GuidePlanes& guides, const NewLight& light,
                  const Image1& valid, FilterPlanes* measured, FilterPlanes* other,
                  LumaImage3* filtered);

}  // namespace stillray
