// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// What an unfinished run leaves behind so that --resume goes on with the same bits: the settings
/// that made it, its log, its last finished frame and the denoiser's history after it.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sequence/finished_files.h"
#include "stillray/denoise.hpp"
#include "stillray/status.h"

namespace stillray {

/// A frame that was filtered and could not be written: the history has its light already.
struct UnwrittenFrame {
  int64_t frame = 0;
  Image3 colour;                   ///< DenoisedFrame::colour
  std::vector<NamedImage> images;  ///< what else its files hold: outputs, or light layers
};

struct ResumeState {
  /// Which files of the folder the run writes, in one line: runs with other keys keep their states
  /// beside each other.
  std::string key;
  std::string fingerprint;                ///< one "name value" a line: what decides the pictures
  std::string log;                        ///< of the frames so far
  int64_t last_frame = 0;                 ///< the last one whose files are complete
  std::vector<FinishedFile> inputs;       ///< of all frames whose light is in the history
  std::vector<FinishedFile> files;        ///< of finished frames
  std::vector<UnwrittenFrame> unwritten;  ///< frames behind last_frame, in their order
  std::vector<uint8_t> history;           ///< of Denoiser::SaveHistory, behind the last of these
};

/// Where the state of a run lies or would lie: "resume.stillray" in its folder, or
/// "resume.2.stillray", ... where that holds the state of another run.
std::string ResumePath(const std::string& folder, const std::string& key);

/// Flushes the files that the state counts as finished to the disk, and then the state: after a
/// power cut it names no frame that is not there.
/// \param synced  [in,out] how many of state.files were flushed before
Status SaveResumeState(const std::string& folder, const ResumeState& state, size_t* synced);

/// \return kNotFound if there is none, kBadData if it is damaged
Result<ResumeState> LoadResumeState(const std::string& folder, const std::string& key);

/// Removes the file, if there is one.
void RemoveResumeState(const std::string& folder, const std::string& key);

/// The first line in which two fingerprints differ, as "it was made with X, this run has Y"; "" if
/// they are equal.
std::string FingerprintDifference(const std::string& made, const std::string& asked);

}  // namespace stillray
