// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Files that are written completely or not at all.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "stillray/status.h"

namespace stillray::io {

/// A file descriptor that is closed at the end of its scope.
class FileDescriptor {
 public:
  FileDescriptor() = default;
  explicit FileDescriptor(int fd) : fd_(fd) {}
  FileDescriptor(FileDescriptor&& other) noexcept : fd_(other.Release()) {}
  FileDescriptor& operator=(FileDescriptor&& other) noexcept;
  FileDescriptor(const FileDescriptor&) = delete;
  FileDescriptor& operator=(const FileDescriptor&) = delete;
  ~FileDescriptor() { Close(); }
  int get() const { return fd_; }
  /// Closes the file: network file systems report a full disk only here. \return false if closing
  /// failed
  bool Close();

 private:
  int Release();
  int fd_ = -1;
};

/// The temporary and the final path of a file.
struct AtomicTarget {
  std::string final_path;  ///< `path` with the last symbolic link resolved
  std::string temp_path;   ///< in the same folder, a random name; empty: write directly
  /// Permissions of the replaced file, which the new file inherits; none: a new file.
  std::optional<unsigned> mode;
};

/// Chooses the temporary name for `path`; creates nothing.
/// \return kNotFound (no such folder), kIo (the path is a folder)
Result<AtomicTarget> PrepareAtomicTarget(const std::string& path);

/// Creates the temporary file, empty, and locks it (flock) for as long as the descriptor is open:
/// an unlocked file is stale, left by a killed process.
/// \param shown_path  the path in messages
Result<FileDescriptor> OpenTemporary(const AtomicTarget& target, const std::string& shown_path);

/// Renames the finished temporary file; removes it if that fails.
Status CommitAtomicTarget(const AtomicTarget& target);

/// As WriteFileAtomically, but durable: flushes the bytes to the disk before the rename, and the
/// folder after it.
Status WriteFileDurably(const std::string& path, const void* bytes, size_t size);

/// Flushes files that were written earlier, and their folders, to the disk.
/// \return kIo naming the file and the system's reason
Status SyncFiles(std::span<const std::string> paths);

/// Removes temporary files of killed processes from a folder. Files of running processes, on this
/// machine or in another container, are kept.
void RemoveStaleTemporaries(const std::string& folder);

/// "PATH: could not be written: No space left on device" for the current errno.
Status WriteError(const std::string& path, int error_number);

}  // namespace stillray::io
