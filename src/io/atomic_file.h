// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Files that appear whole or not at all.
#pragma once

#include <optional>
#include <string>

#include "stillray/status.h"

namespace stillray::io {

/// Where a file is written first and what it becomes.
struct AtomicTarget {
  std::string final_path;  ///< `path` with a last symbolic link followed
  std::string temp_path;   ///< in the same folder, unique to this call; empty: write directly
  /// Rights of the file that is replaced, which the new one gets too; none: a new file.
  std::optional<unsigned> mode;
};

/// Picks the temporary name for `path`; makes nothing.
/// \return kNotFound (no such folder), kIo (the path is a folder)
Result<AtomicTarget> PrepareAtomicTarget(const std::string& path);

/// Renames the finished temporary file; removes it if that fails.
Status CommitAtomicTarget(const AtomicTarget& target);

/// "PATH: could not be written: No space left on device" for the current errno.
Status WriteError(const std::string& path, int error_number);

}  // namespace stillray::io
