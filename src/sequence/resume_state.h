// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The state of an unfinished run, from which --resume continues with bit-identical results:
/// settings, log, last finished frame, and the denoiser's history after that frame.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sequence/finished_files.h"
#include "stillray/denoise.hpp"
#include "stillray/status.h"

namespace stillray {

/// A frame that was filtered but could not be written: its radiance is in the history.
struct UnwrittenFrame {
  int64_t frame = 0;
  Image3 colour;                   ///< DenoisedFrame::colour
  std::vector<NamedImage> images;  ///< other images in its files: outputs, or light layers
};

struct ResumeState {
  /// Identifies the files that the run writes, in one line: states of runs with other keys are kept
  /// separately.
  std::string key;
  /// one "name value" a line: all settings that affect the output
  std::string fingerprint;
  std::string log;                        ///< of the frames so far
  int64_t last_frame = 0;                 ///< the last one whose files are complete
  std::vector<FinishedFile> inputs;       ///< of all frames whose radiance is in the history
  std::vector<FinishedFile> files;        ///< of finished frames
  std::vector<UnwrittenFrame> unwritten;  ///< frames after last_frame, in order
  std::vector<uint8_t> history;  ///< by Denoiser::SaveHistory, after the last unwritten frame
};

/// The path of a run's state: "resume.stillray" in the run's folder, or "resume.2.stillray", ... if
/// that file belongs to another run.
std::string ResumePath(const std::string& folder, const std::string& key);

/// Flushes the files that the state lists as finished to the disk, and then the state: after a
/// power failure it lists no missing frame.
/// \param synced  [in,out] number of state.files that are already flushed
Status SaveResumeState(const std::string& folder, const ResumeState& state, size_t* synced);

/// \return kNotFound if there is no state, kBadData if it is damaged
Result<ResumeState> LoadResumeState(const std::string& folder, const std::string& key);

/// Removes the file, if there is one.
void RemoveResumeState(const std::string& folder, const std::string& key);

/// The first difference between two fingerprints, lines of a setting's name and its value, as "it
/// was made with X, this run has Y", or of a setting that only one of them has; "" if they are
/// equal.
std::string FingerprintDifference(const std::string& made, const std::string& asked);

}  // namespace stillray
