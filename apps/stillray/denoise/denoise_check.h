// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Runs the doctor on the first frames of a sequence, before it is denoised.
#pragma once

#include <vector>

#include "denoise/denoise_options.h"
#include "stillray/doctor.h"

namespace stillray {

/// Number of examined frames: three pairs reveal faults of motion, noise and exposure, and
/// measuring them takes about as long as denoising as many frames.
inline constexpr size_t kCheckedFrames = 4;

/// Findings in the first frames, without those that denoising reports itself: gaps, other sizes and
/// layers, layers that the user disables (--aov motion=none), and lacking motion that is derived. A
/// file that cannot be read ends the examination without an error: denoising reports it later.
/// \return kCancelled; else errors of Doctor::Report
Result<std::vector<Finding>> CheckFirstFrames(const DenoiseOptions& options, bool derives_motion);

/// Notes of the layout, without those that repeat a finding.
std::vector<std::string> NotesBeside(const std::vector<Finding>& findings, const AovLayout& layout);

bool HasFinding(const std::vector<Finding>& findings, std::string_view name);

}  // namespace stillray
