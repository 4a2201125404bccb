// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The files of frames that a run has finished, so that --resume finds out whether they are still
/// what they were.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "stillray/status.h"

namespace stillray {

struct FinishedFile {
  std::string name;       ///< within the folder of the run
  uint64_t bytes = 0;     ///< its size
  uint64_t checksum = 0;  ///< of its beginning and its end
};

/// What a file is like now. Reads a few kilobytes of it, however large it is.
/// \return kNotFound, kIo naming the path and the system's reason
Result<FinishedFile> LookAtFile(const std::string& folder, const std::string& name);

/// Adds what LookAtFile says of each of these paths, all in the folder of the run.
Status AddFinishedFiles(const std::string& folder, const std::vector<std::string>& paths,
                        std::vector<FinishedFile>* files);

/// What is wrong with the first file that is no longer what it was, as "PATH is missing", "PATH is
/// empty" or "PATH has changed since"; "" where all are.
std::string FirstChanged(const std::string& folder, const std::vector<FinishedFile>& files);

}  // namespace stillray
