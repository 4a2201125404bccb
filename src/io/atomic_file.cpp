// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "io/atomic_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <new>
#include <system_error>

#include <fmt/format.h>

#include "stillray/io.h"

namespace stillray::io {

namespace {

namespace fs = std::filesystem;

// A file name may have 255 bytes; the temporary name adds ".tmp-", two numbers and dots.
constexpr size_t kMaxNameInTemp = 200;
// As many as Linux itself follows.
constexpr int kMaxLinks = 40;
// Linux moves at most 2 GiB - 4 KiB per call.
constexpr size_t kMaxTransfer = size_t{1} << 30;

/// A file descriptor that is closed at the end of its scope.
class FileDescriptor {
 public:
  explicit FileDescriptor(int fd) : fd_(fd) {}
  FileDescriptor(const FileDescriptor&) = delete;
  FileDescriptor& operator=(const FileDescriptor&) = delete;
  ~FileDescriptor() {
    if (fd_ >= 0) {
      ::close(fd_);
    }
  }
  int get() const { return fd_; }
  /// Closes and tells: network file systems report a full disk only here.
  bool Close() {
    const int fd = fd_;
    fd_ = -1;
    return ::close(fd) == 0;
  }

 private:
  int fd_;
};

std::string Reason(int error_number) {
  return std::generic_category().message(error_number);
}

bool WriteAll(int fd, const char* bytes, size_t size) {
  while (size > 0) {
    const ssize_t written = ::write(fd, bytes, std::min(size, kMaxTransfer));
    if (written < 0) {
      if (errno == EINTR) {
        continue;
      }
      return false;
    }
    bytes += written;
    size -= static_cast<size_t>(written);
  }
  return true;
}

/// \param mode  of a file that is made; none: as the user's mask has it
Status WriteTo(const std::string& open_path, int flags, const std::optional<unsigned>& mode,
               const std::string& shown_path, const void* bytes, size_t size) {
  FileDescriptor file(::open(open_path.c_str(), flags | O_WRONLY | O_CLOEXEC, mode.value_or(0666)));
  if (file.get() < 0) {
    return WriteError(shown_path, errno);
  }
  // The mask took rights away that the file before it had. Where that is not possible, fewer rights
  // do no harm.
  if (mode) {
    static_cast<void>(::fchmod(file.get(), *mode));
  }
  if (!WriteAll(file.get(), static_cast<const char*>(bytes), size)) {
    return WriteError(shown_path, errno);
  }
  return file.Close() ? Status::Ok() : WriteError(shown_path, errno);
}

}  // namespace

Status WriteError(const std::string& path, int error_number) {
  return Status::Io(fmt::format("{}: could not be written: {}", path, Reason(error_number)));
}

Result<AtomicTarget> PrepareAtomicTarget(const std::string& path) {
  if (path.empty()) {
    return Status::InvalidArgument("the path of a file to write is empty");
  }
  std::error_code error;
  AtomicTarget target;
  target.final_path = path;
  // Link by link, as the last one may point to a file that does not exist yet.
  for (int links = 0; fs::is_symlink(target.final_path, error); ++links) {
    const fs::path link(target.final_path);
    const fs::path next = fs::read_symlink(link, error);
    if (error || links == kMaxLinks) {
      return WriteError(path, error ? error.value() : ELOOP);
    }
    target.final_path = (link.parent_path() / next).string();
  }
  const fs::file_status status = fs::status(target.final_path, error);
  if (fs::is_directory(status)) {
    return Status::Io(fmt::format("{}: could not be written: it is a folder", path));
  }
  if (fs::exists(status) && !fs::is_regular_file(status)) {
    return target;
  }
  if (fs::is_regular_file(status)) {
    target.mode = static_cast<unsigned>(status.permissions() & fs::perms::all);
  }
  const fs::path final_path(target.final_path);
  const fs::path folder = final_path.parent_path();
  if (!folder.empty() && !fs::is_directory(folder, error)) {
    return Status::NotFound(fmt::format("{}: could not be written: the folder {} does not exist",
                                        path, folder.string()));
  }
  if (!final_path.has_filename()) {
    return Status::Io(fmt::format("{}: could not be written: it is a folder", path));
  }
  static std::atomic<unsigned> counter{0};
  const std::string name = final_path.filename().string().substr(0, kMaxNameInTemp);
  target.temp_path =
      (folder / fmt::format(".{}.tmp-{}-{}", name, ::getpid(), counter.fetch_add(1))).string();
  return target;
}

Status CommitAtomicTarget(const AtomicTarget& target) {
  if (target.temp_path.empty()) {
    return Status::Ok();
  }
  if (std::rename(target.temp_path.c_str(), target.final_path.c_str()) != 0) {
    const Status status = WriteError(target.final_path, errno);
    ::unlink(target.temp_path.c_str());
    return status;
  }
  return Status::Ok();
}

}  // namespace stillray::io

namespace stillray {

Status WriteFileAtomically(const std::string& path, const void* bytes, size_t size) {
  Result<io::AtomicTarget> target = io::PrepareAtomicTarget(path);
  if (!target.ok()) {
    return target.status();
  }
  if (target->temp_path.empty()) {
    return io::WriteTo(target->final_path, 0, std::nullopt, path, bytes, size);
  }
  // O_EXCL: a file of that name can only be what a process with the same id left behind when it was
  // killed, so it may go.
  ::unlink(target->temp_path.c_str());
  const Status status =
      io::WriteTo(target->temp_path, O_CREAT | O_EXCL, target->mode, path, bytes, size);
  if (!status.ok()) {
    ::unlink(target->temp_path.c_str());
    return status;
  }
  return io::CommitAtomicTarget(*target);
}

Result<std::string> ReadWholeFile(const std::string& path, size_t max_size) {
  // A pipe without a writer would block before it could be refused.
  io::FileDescriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (file.get() < 0) {
    if (errno == ENOENT || errno == ENOTDIR) {
      return Status::NotFound(fmt::format("{}: there is no such file", path));
    }
    return Status::Io(fmt::format("{}: could not be opened: {}", path, io::Reason(errno)));
  }
  struct stat info {};
  if (::fstat(file.get(), &info) != 0) {
    return Status::Io(fmt::format("{}: could not be read: {}", path, io::Reason(errno)));
  }
  if (S_ISDIR(info.st_mode)) {
    return Status::Io(fmt::format("{}: is a folder, not a file", path));
  }
  if (!S_ISREG(info.st_mode)) {
    return Status::Io(fmt::format("{}: is not an ordinary file", path));
  }
  const auto too_large = [&] {
    return Status::Unsupported(
        fmt::format("{}: is larger than {} bytes, the most that is read", path, max_size));
  };
  const auto known_size = static_cast<uint64_t>(info.st_size);
  if (known_size > max_size) {
    return too_large();
  }
  try {
    // One byte more than expected, so that the end is seen without another round; files that grow
    // simply take further rounds.
    constexpr size_t kStep = size_t{1} << 16;
    std::string bytes(std::max<size_t>(known_size, kStep) + 1, '\0');
    size_t used = 0;
    while (true) {
      if (used == bytes.size()) {
        bytes.resize(bytes.size() * 2);
      }
      const ssize_t got =
          ::read(file.get(), bytes.data() + used, std::min(bytes.size() - used, io::kMaxTransfer));
      if (got < 0 && errno == EINTR) {
        continue;
      }
      if (got < 0) {
        return Status::Io(fmt::format("{}: could not be read: {}", path, io::Reason(errno)));
      }
      used += static_cast<size_t>(got);
      if (used > max_size) {
        return too_large();
      }
      if (got == 0) {
        break;
      }
    }
    bytes.resize(used);
    return bytes;
  } catch (const std::bad_alloc&) {
    return Status::OutOfMemory(fmt::format("{}: not enough memory to read it", path));
  }
}

}  // namespace stillray
