// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "common/output_folder.h"

#include <fcntl.h>
#include <sys/file.h>

#include <cerrno>
#include <filesystem>
#include <system_error>

#include <fmt/format.h>

#include "common/console.h"

namespace stillray {

Status MakeOutputFolder(const std::string& folder) {
  if (folder.empty()) {
    return Status::Ok();
  }
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error || !std::filesystem::is_directory(folder)) {
    return Status::Io(fmt::format("cannot make the folder {}: {}", folder,
                                  error ? error.message() : "a file of that name exists"));
  }
  return Status::Ok();
}

bool OutputFolderMark::Set(const std::string& folder) {
  const char* path = folder.empty() ? "." : folder.c_str();
  folder_ = io::FileDescriptor(::open(path, O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  return folder_.get() < 0 || ::flock(folder_.get(), LOCK_EX | LOCK_NB) == 0 ||
         errno != EWOULDBLOCK;
}

void MarkOutputFolder(const std::string& folder, OutputFolderMark* mark) {
  if (!mark->Set(folder)) {
    PrintTo(stderr,
            "warning: another run is writing to {}; of files with the same name the later one "
            "stays\n",
            folder.empty() ? "./" : folder);
  }
}

}  // namespace stillray
