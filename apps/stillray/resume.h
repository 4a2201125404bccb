// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// What an unfinished run leaves behind so that --resume goes on with the same bits: the settings
/// that made it, its log, its last finished frame and the denoiser's history after it.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "stillray/status.h"

namespace stillray {

struct ResumeState {
  std::string fingerprint;  ///< see RenderFingerprint
  std::string log;          ///< render.json so far
  int64_t last_frame = 0;
  std::vector<uint8_t> history;  ///< of Denoiser::SaveHistory
};

/// The file's path in the folder of a run.
std::string ResumePath(const std::string& folder);

Status SaveResumeState(const std::string& folder, const ResumeState& state);

/// \return kNotFound if there is none, kBadData if it is damaged
Result<ResumeState> LoadResumeState(const std::string& folder);

/// Removes the file, if there is one.
void RemoveResumeState(const std::string& folder);

/// The first line in which two fingerprints differ, as "it was made with X, this run has Y"; "" if
/// they are equal.
std::string FingerprintDifference(const std::string& made, const std::string& asked);

}  // namespace stillray
