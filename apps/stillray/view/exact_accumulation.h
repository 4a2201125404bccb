// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Accumulation without an end: what a view that stands still needs to converge.
#pragma once

#include "stillray/denoise.hpp"

namespace stillray::view {

/// Whether every sample counts the same for ever: history_weight=age, alpha_min=0, alpha_moments=0,
/// max_history=0, limit_history=off, feedback=0, variance_of=mean.
bool AccumulatesExactly(const Settings& settings);

/// Sets these, or gives them back the values that they have in `preset`. Light that moves leaves
/// trails while it is on.
void SetExactAccumulation(bool on, const Settings& preset, Settings* settings);

}  // namespace stillray::view
