// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The coarse grid of limit_history and restore_energy, and the wavelet levels on it.
#pragma once

#include "denoise/cpu/frame_work.h"
#include "denoise/cpu/pipeline.h"

namespace stillray {

/// A mask with the bits of all signals.
inline constexpr int kAllSignals = ~0;

/// Allocates the planes of the coarse grid, if necessary.
void MakeCoarsePlanes(const GuidePlanes& guides, size_t signals, LayerWork* work);

/// Runs levels on the coarse grid, alternating between ComparedPlanes::light and
/// ComparedPlanes::work; the input is in `light`.
/// \param mask  bit s: run the levels for signal s
void RunComparedLevels(const CpuPipeline& p, int levels, int mask, LayerWork* work);

/// Computes the wide change of each signal from the output of correct_history's levels.
void RunWideLevel(const CpuPipeline& p, LayerWork* work);

}  // namespace stillray
