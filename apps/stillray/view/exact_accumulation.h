// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Unlimited accumulation, with which a static view converges.
#pragma once

#include "stillray/denoise.hpp"

namespace stillray::view {

/// Whether all samples have equal weight forever: history_weight=age, alpha_min=0, alpha_moments=0,
/// max_history=0, limit_history=off, feedback=0, variance_of=mean.
bool AccumulatesExactly(const Settings& settings);

/// Sets these, or restores their values in `preset`. Moving light leaves trails while it is on.
void SetExactAccumulation(bool on, const Settings& preset, Settings* settings);

/// Gives all samples equal weight as SetExactAccumulation does, with members that keep the history:
/// temporal and history_weight stay, limit_gain=0 and correct_history=off stand for
/// limit_history=off. For frames of a view in which nothing moves; no other frames may use it.
void WeighSamplesEqually(Settings* settings);

}  // namespace stillray::view
