// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "sequence/finished_files.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <filesystem>
#include <span>
#include <system_error>

#include <fmt/format.h>

#include "core/checksum.h"
#include "io/atomic_file.h"

namespace stillray {
namespace {

/// Size of the compared parts at both ends of a file, which contain headers and the last pixels:
/// they differ if a power failure left the file empty, truncated or zeroed, and in images of other
/// settings.
constexpr size_t kEndBytes = 4096;

Status ReadError(const std::string& path, int error_number) {
  return Status(error_number == ENOENT ? StatusCode::kNotFound : StatusCode::kIo,
                fmt::format("{}: could not be read: {}", path,
                            std::generic_category().message(error_number)));
}

}  // namespace

Result<FinishedFile> LookAtFile(const std::string& folder, const std::string& name) {
  const std::string path = (std::filesystem::path(folder) / name).string();
  const io::FileDescriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  struct stat info {};
  if (file.get() < 0 || ::fstat(file.get(), &info) != 0) {
    return ReadError(path, errno);
  }
  FinishedFile found;
  found.name = name;
  found.bytes = static_cast<uint64_t>(info.st_size);
  found.checksum = kEmptyChecksum;
  const auto end = static_cast<off_t>(std::min<uint64_t>(kEndBytes, found.bytes));
  for (const off_t at : {off_t{0}, static_cast<off_t>(found.bytes) - end}) {
    std::array<uint8_t, kEndBytes> bytes{};
    const ssize_t got = ::pread(file.get(), bytes.data(), static_cast<size_t>(end), at);
    if (got < 0) {
      return ReadError(path, errno);
    }
    found.checksum =
        AddToChecksum(std::span(bytes).first(static_cast<size_t>(got)), found.checksum);
  }
  return found;
}

Status AddFinishedFiles(const std::string& folder, const std::vector<std::string>& paths,
                        std::vector<FinishedFile>* files) {
  for (const std::string& path : paths) {
    Result<FinishedFile> file = LookAtFile(folder, std::filesystem::path(path).filename().string());
    STILLRAY_RETURN_IF_ERROR(file.status());
    files->push_back(std::move(file.value()));
  }
  return Status::Ok();
}

std::string FirstChanged(const std::string& folder, const std::vector<FinishedFile>& files) {
  for (const FinishedFile& was : files) {
    const std::string path = (std::filesystem::path(folder) / was.name).string();
    const Result<FinishedFile> is = LookAtFile(folder, was.name);
    if (!is.ok()) {
      return is.status().code() == StatusCode::kNotFound ? path + " is missing"
                                                         : is.status().message();
    }
    if (is->bytes == 0) {
      return path + " is empty";
    }
    if (is->bytes != was.bytes || is->checksum != was.checksum) {
      return path + " has changed since";
    }
  }
  return "";
}

}  // namespace stillray
