// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "denoise/cpu/pipeline.h"
#include "denoise/cpu/signals.h"

namespace stillray {

/// restore_detail and its wavelet levels, in WaveletPlanes::light of every signal that has detail.
/// The residuals of this frame become history.
void RunRestoreDetail(const CpuPipeline& p, LayerHistory* history, LayerWork* work,
                      DenoisedFrame* out);

}  // namespace stillray
