// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "common/output_folder.h"

#include <filesystem>
#include <system_error>

#include <fmt/format.h>

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

}  // namespace stillray
