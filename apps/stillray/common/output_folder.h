// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The folder of output files.
#pragma once

#include <string>

#include "io/atomic_file.h"
#include "stillray/status.h"

namespace stillray {

/// Creates the folder and its parents if necessary. "" is the current folder.
/// \return kIo naming the folder and the reason
Status MakeOutputFolder(const std::string& folder);

/// Marks a folder as the output of this process, for as long as the object exists. The mark is a
/// lock on the folder itself: it creates no file, and is released with the process.
class OutputFolderMark {
 public:
  /// \return false if another process has marked the folder. True if the system cannot lock folders
  bool Set(const std::string& folder);

 private:
  io::FileDescriptor folder_;
};

/// Marks the folder and prints a warning if another run is writing to it.
void MarkOutputFolder(const std::string& folder, OutputFolderMark* mark);

}  // namespace stillray
