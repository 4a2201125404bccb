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

/// Settings that give all samples equal weight as SetExactAccumulation does, and keep the history:
/// limit_gain=0 and correct_history=off in place of limit_history=off. Blended feedback has a
/// history of its own: with one signal the picture on the screen becomes the new history
/// (ViewSession::CanSeed), with several the settings are returned unchanged. Only for frames in
/// which nothing moves.
Settings WithEqualWeights(const Settings& settings);

}  // namespace stillray::view
