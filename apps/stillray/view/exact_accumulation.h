// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Unlimited accumulation, with which a static view converges.
#pragma once

#include "stillray/denoise.hpp"

namespace stillray::view {

/// Whether all samples have equal weight without limit: history_weight=age, alpha_min=0,
/// alpha_moments=0, max_history=0, limit_history=off, feedback=0, variance_of=mean.
bool AccumulatesExactly(const Settings& settings);

/// Sets the parameters of AccumulatesExactly, or restores their values in `preset`. Changing light
/// leaves trails in this mode.
void SetExactAccumulation(bool on, const Settings& preset, Settings* settings);

/// Like SetExactAccumulation, gives all samples equal weight, but keeps the history: limit_gain=0
/// and correct_history=off instead of limit_history=off. Blended feedback has a separate history:
/// with one signal the displayed image becomes the new history (ViewSession::CanSeed), with several
/// signals the settings are returned unchanged. Only for static frames.
Settings WithEqualWeights(const Settings& settings);

}  // namespace stillray::view
