// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The last line of a run over many frames: number of files, folder, size and speed, or the reason
/// why the run stopped.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "stillray/status.h"

namespace stillray {

/// "212 MB", "1.3 GB", "640 kB", "12 bytes": decimal units, as in file managers.
std::string FormatBytes(int64_t bytes);

struct RunSummary {
  size_t frames = 0;         ///< frames written by this run
  size_t frames_before = 0;  ///< frames finished by the resumed earlier run
  std::string place;         ///< output folder; "" is the current folder
  int64_t bytes = 0;         ///< size of all files of these frames
  double seconds = 0;        ///< time for these frames, including reading, filtering and writing
};

/// Patterns of file names, one per sequence, in order of first occurrence: "denoised.####.exr,
/// denoised.mp4".
std::string FilePatternsText(const std::vector<std::string>& names);

/// "wrote 16 frames to clean/ (212 MB) in 3.2 s, 200 ms per frame"
std::string RunSummaryText(const RunSummary& summary);

/// State of a run that ended before its last frame.
struct StoppedRun {
  Status status;       ///< reason for the stop; kCancelled: by the user
  Status save_status;  ///< result of saving the state for --resume
  size_t finished = 0;
  size_t frames = 0;         ///< number of frames of the complete run
  std::string resumes_from;  ///< "frame 4", "here"; empty: no saved state
};

/// The error of the run: the reason, the number of finished frames, and where --resume continues.
Status StopError(const StoppedRun& run);

/// Size of a file on disk; 0 if there is none.
int64_t FileBytes(const std::string& path);

}  // namespace stillray
