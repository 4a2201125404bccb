// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Identifies the files of finished frames, so that --resume detects changes.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "stillray/status.h"

namespace stillray {

struct FinishedFile {
  std::string name;       ///< within the folder of the run
  uint64_t bytes = 0;     ///< size of the file
  uint64_t checksum = 0;  ///< of the beginning and the end of the file
};

/// The current state of a file. Reads a few kilobytes, independent of the file's size.
/// \return kNotFound, kIo naming the path and the system's reason
Result<FinishedFile> LookAtFile(const std::string& folder, const std::string& name);

/// Adds the state of each of these paths, all in the folder of the run.
Status AddFinishedFiles(const std::string& folder, const std::vector<std::string>& paths,
                        std::vector<FinishedFile>* files);

/// The first file that has changed, as "PATH is missing", "PATH is empty" or "PATH has changed
/// since"; "" if there is none.
std::string FirstChanged(const std::string& folder, const std::vector<FinishedFile>& files);

}  // namespace stillray
