// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// What both pipelines, on the CPU and on Vulkan, make of the settings.
#pragma once

#include "stillray/denoise.hpp"

namespace stillray {

/// Samples that the 7x7 neighbourhood must have below one per pixel.
inline constexpr float kLeastEvidence = 4.0f;

/// Lengths are means of whole numbers with weights that sum to one but for rounding: a little less
/// than the limit is no short history, or roundings would decide.
inline float ShortHistoryLength(const Settings& s) {
  constexpr float kRounding = 1e-3f;
  return static_cast<float>(s.short_history_length) - kRounding;
}

/// Whether what was remembered under the settings \p a is of no use under \p b.
bool NeedsNewHistory(const Settings& a, const Settings& b);

}  // namespace stillray
