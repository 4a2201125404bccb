// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The last line of a run over many frames: what was written, where, how much, how fast.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace stillray {

/// "212 MB", "1.3 GB", "640 kB", "12 bytes": decimal units, as file managers and disks have them.
std::string FormatBytes(int64_t bytes);

struct RunSummary {
  size_t frames = 0;         ///< written by this run
  size_t frames_before = 0;  ///< finished by an earlier run that this one went on with
  std::string place;         ///< the folder; "" is the current one
  int64_t bytes = 0;         ///< of all files of these frames
  double seconds = 0;        ///< of these frames, reading, filtering and writing included
};

/// "wrote 16 frames to clean/ (212 MB) in 3.2 s, 200 ms per frame"
std::string RunSummaryText(const RunSummary& summary);

/// Size of a file on disk; 0 where there is none.
int64_t FileBytes(const std::string& path);

}  // namespace stillray
