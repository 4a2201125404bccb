// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Runs the doctor on the first frames of a sequence before denoising.
#pragma once

#include <vector>

#include "denoise/denoise_options.h"
#include "stillray/doctor.h"

namespace stillray {

/// Number of examined frames: three pairs reveal errors in motion, noise and exposure, and their
/// examination takes about as long as denoising them.
inline constexpr size_t kCheckedFrames = 4;

/// Findings in the first frames, without findings that denoising reports: gaps, differing sizes and
/// layers, layers disabled by the user (--aov motion=none), and missing motion that is derived. An
/// unreadable file ends the examination without an error: denoising reports it later.
/// \return kCancelled; else errors of Doctor::Report
Result<std::vector<Finding>> CheckFirstFrames(const DenoiseOptions& options, bool derives_motion);

/// Notes of the layout, without notes that repeat a finding.
std::vector<std::string> NotesBeside(const std::vector<Finding>& findings, const AovLayout& layout);

bool HasFinding(const std::vector<Finding>& findings, std::string_view name);

}  // namespace stillray
