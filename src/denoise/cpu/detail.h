// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "denoise/cpu/pipeline.h"
#include "denoise/cpu/signals.h"

namespace stillray {

/// Runs restore_detail and its wavelet levels on WaveletPlanes::light of every signal in
/// RestoreDetailParameters::detail_signals. The residuals of this frame are added to the history.
void RunRestoreDetail(const CpuPipeline& p, LayerHistory* history, LayerWork* work,
                      DenoisedFrame* out);

}  // namespace stillray
