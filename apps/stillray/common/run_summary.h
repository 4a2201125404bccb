// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The last line of a run over many frames: number of files, folder, size and speed, or why it
/// stopped.
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
  size_t frames = 0;         ///< written by this run
  size_t frames_before = 0;  ///< finished by the earlier run that this one resumed
  std::string place;         ///< the folder; "" is the current one
  int64_t bytes = 0;         ///< of all files of these frames
  double seconds = 0;        ///< of these frames, including reading, filtering and writing
};

/// Names of files by sequence, in the order of the first of each: "denoised.####.exr,
/// denoised.mp4".
std::string FilePatternsText(const std::vector<std::string>& names);

/// "wrote 16 frames to clean/ (212 MB) in 3.2 s, 200 ms per frame"
std::string RunSummaryText(const RunSummary& summary);

/// A run that ended before its last frame.
struct StoppedRun {
  Status status;       ///< the reason; kCancelled: by the user
  Status save_status;  ///< of the state for --resume
  size_t finished = 0;
  size_t frames = 0;         ///< of the whole run
  std::string resumes_from;  ///< "frame 4", "here"; empty: no state
};

/// The error of the run: the reason, the number of finished frames, and where --resume continues.
Status StopError(const StoppedRun& run);

/// Size of a file on disk; 0 if there is none.
int64_t FileBytes(const std::string& path);

}  // namespace stillray
