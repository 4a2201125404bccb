// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// What the doctor finds in the first frames of a sequence, before it is denoised.
#pragma once

#include <vector>

#include "denoise/denoise_options.h"
#include "stillray/doctor.h"

namespace stillray {

/// Frames that are looked at: three pairs tell motion, noise and exposure, and measuring them takes
/// about as long as denoising as many frames.
inline constexpr size_t kCheckedFrames = 4;

/// Findings in the first frames. Left out is what denoising says by itself: gaps, other sizes and
/// layers, and what the user leaves away (--aov motion=none). A file that cannot be read ends the
/// look at it without an error: denoising reports it in its turn.
/// \return kCancelled where the user stopped; else what Doctor::Report returns
Result<std::vector<Finding>> CheckFirstFrames(const DenoiseOptions& options,
                                              const AovLayout& layout);

/// Notes of the layout without those that a finding says too.
std::vector<std::string> NotesBeside(const std::vector<Finding>& findings, const AovLayout& layout);

bool HasFinding(const std::vector<Finding>& findings, std::string_view name);

}  // namespace stillray
