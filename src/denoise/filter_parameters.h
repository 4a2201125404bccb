// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// What both pipelines, on the CPU and on Vulkan, make of the settings.
#pragma once

#include "denoise/stages/edge_stopping.h"
#include "stillray/denoise.hpp"

namespace stillray {

/// Sums of samples are whole numbers but for rounding, or means of such: a little less than a limit
/// reaches it, or roundings would decide.
inline constexpr float kSampleRounding = 1e-3f;

/// Samples that the 7x7 neighbourhood must have below one per pixel.
inline constexpr float kLeastEvidence = 4.0f - kSampleRounding;

/// Histories below it are short.
inline float ShortHistoryLength(const Settings& s) {
  return static_cast<float>(s.short_history_length) - kSampleRounding;
}

/// Whether what was remembered under the settings \p a is of no use under \p b.
bool NeedsNewHistory(const Settings& a, const Settings& b);

/// Whether the rays of a frame went through other points than the pixels' centres.
inline bool IsJittered(float jitter_x, float jitter_y) {
  return jitter_x != 0 || jitter_y != 0;
}

/// Whether pictures are antialiased in time. \param jittered  this frame or one before it was
inline bool AntialiasesInTime(const Settings& s, bool jittered) {
  return s.antialias == Antialias::kTaa || (s.antialias == Antialias::kAuto && jittered);
}

/// What stops the wavelet at edges of the guides, of the settings.
inline EdgeStopping EdgesOf(const Settings& s) {
  EdgeStopping edges;
  edges.sigma_n = s.sigma_n;
  edges.plane = s.depth_weight == DepthWeight::kPlane;
  edges.sigma_z = s.sigma_z;
  edges.plane_tolerance = s.plane_tolerance;
  edges.depth_epsilon = s.depth_epsilon;
  edges.max_slope = s.max_slope;
  return edges;
}

}  // namespace stillray
