// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The coarse grid of limit_history and restore_energy, and its levels.
#pragma once

#include "denoise/cpu/frame_work.h"
#include "denoise/cpu/pipeline.h"

namespace stillray {

/// A bit per signal of the layer.
inline constexpr int kAllSignals = ~0;

/// Allocates the planes of the coarse grid, if necessary.
void MakeCoarsePlanes(const GuidePlanes& guides, size_t signals, LayerWork* work);

/// Runs levels on the coarse grid from ComparedPlanes::light to `work` and back, and so on.
/// \param mask  bit s: of signal s
void RunComparedLevels(const CpuPipeline& p, int levels, int mask, LayerWork* work);

/// The wide change of each signal, from the light that the levels of correct_history have averaged.
void RunWideLevel(const CpuPipeline& p, LayerWork* work);

}  // namespace stillray
