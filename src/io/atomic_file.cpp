// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "io/atomic_file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <new>
#include <set>
#include <string_view>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "stillray/io.h"

namespace stillray::io {

namespace {

namespace fs = std::filesystem;

/// A file name may have 255 bytes; the temporary name adds a dot, ".tmp-" and 16 digits.
constexpr size_t kMaxNameInTemp = 200;
/// The limit of Linux.
constexpr int kMaxLinks = 40;
/// Linux moves at most 2 GiB - 4 KiB per call.
constexpr size_t kMaxTransfer = size_t{1} << 30;

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

/// Flushes to the disk. Devices and some file systems do not support it.
bool Flush(int fd) {
  return ::fsync(fd) == 0 || errno == EINVAL || errno == ENOTSUP || errno == EROFS;
}

Status FillAndClose(FileDescriptor file, const std::string& shown_path, const void* bytes,
                    size_t size, bool durable) {
  if (!WriteAll(file.get(), static_cast<const char*>(bytes), size) ||
      (durable && !Flush(file.get())) || !file.Close()) {
    return WriteError(shown_path, errno);
  }
  return Status::Ok();
}

Status SyncPath(const std::string& path, int flags) {
  const FileDescriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | flags));
  return file.get() >= 0 && Flush(file.get()) ? Status::Ok() : WriteError(path, errno);
}

std::string FolderOf(const std::string& path) {
  const fs::path folder = fs::path(path).parent_path();
  return folder.empty() ? "." : folder.string();
}

/// The suffix of a temporary name: a mark and sixteen hexadecimal digits.
constexpr std::string_view kTempMark = ".tmp-";
constexpr size_t kTempDigits = 16;

/// Unpredictable, and different in processes with the same id (in two containers).
uint64_t RandomNumber() {
  uint64_t number = 0;
  if (::getrandom(&number, sizeof(number), 0) != static_cast<ssize_t>(sizeof(number))) {
    static std::atomic<uint64_t> counter{0};
    number = (static_cast<uint64_t>(::getpid()) << 32) + counter.fetch_add(1);
  }
  return number;
}

bool IsTemporaryName(std::string_view name) {
  const size_t tail = kTempMark.size() + kTempDigits;
  return name.size() > tail + 1 && name[0] == '.' &&
         name.substr(name.size() - tail, kTempMark.size()) == kTempMark &&
         name.find_first_not_of("0123456789abcdef", name.size() - kTempDigits) ==
             std::string_view::npos;
}

Status WriteWhole(const std::string& path, const void* bytes, size_t size, bool durable) {
  Result<AtomicTarget> target = PrepareAtomicTarget(path);
  if (!target.ok()) {
    return target.status();
  }
  if (target->temp_path.empty()) {
    FileDescriptor file(::open(target->final_path.c_str(), O_WRONLY | O_CLOEXEC));
    return file.get() < 0 ? WriteError(path, errno)
                          : FillAndClose(std::move(file), path, bytes, size, false);
  }
  Result<FileDescriptor> file = OpenTemporary(*target, path);
  STILLRAY_RETURN_IF_ERROR(file.status());
  // Holds the lock until the file is renamed.
  const FileDescriptor lock(::fcntl(file->get(), F_DUPFD_CLOEXEC, 0));
  const Status status = FillAndClose(std::move(file.value()), path, bytes, size, durable);
  if (!status.ok()) {
    ::unlink(target->temp_path.c_str());
    return status;
  }
  STILLRAY_RETURN_IF_ERROR(CommitAtomicTarget(*target));
  return durable ? SyncPath(FolderOf(target->final_path), O_DIRECTORY) : Status::Ok();
}

}  // namespace

FileDescriptor& FileDescriptor::operator=(FileDescriptor&& other) noexcept {
  if (this != &other) {
    Close();
    fd_ = other.Release();
  }
  return *this;
}

bool FileDescriptor::Close() {
  const int fd = Release();
  return fd < 0 || ::close(fd) == 0;
}

int FileDescriptor::Release() {
  const int fd = fd_;
  fd_ = -1;
  return fd;
}

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
  const std::string name = final_path.filename().string().substr(0, kMaxNameInTemp);
  target.temp_path =
      (folder / fmt::format(".{}{}{:016x}", name, kTempMark, RandomNumber())).string();
  return target;
}

Result<FileDescriptor> OpenTemporary(const AtomicTarget& target, const std::string& shown_path) {
  constexpr int kFlags = O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC;
  // Another process may remove a file that is not locked yet as stale.
  for (int attempt = 0; attempt < 8; ++attempt) {
    FileDescriptor file(::open(target.temp_path.c_str(), kFlags, target.mode.value_or(0666)));
    if (file.get() < 0) {
      return WriteError(shown_path, errno);
    }
    // Restores permissions that the umask removed. On failure the file has fewer permissions, which
    // is harmless.
    if (target.mode) {
      static_cast<void>(::fchmod(file.get(), *target.mode));
    }
    // Without locks, as on some network file systems, stale files are not detected either.
    static_cast<void>(::flock(file.get(), LOCK_EX));
    struct stat info {};
    if (::fstat(file.get(), &info) != 0 || info.st_nlink > 0) {
      return file;
    }
  }
  return WriteError(shown_path, EAGAIN);
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

Status WriteFileDurably(const std::string& path, const void* bytes, size_t size) {
  return WriteWhole(path, bytes, size, true);
}

Status SyncFiles(std::span<const std::string> paths) {
  std::set<std::string> folders;
  for (const std::string& path : paths) {
    STILLRAY_RETURN_IF_ERROR(SyncPath(path, 0));
    folders.insert(FolderOf(path));
  }
  for (const std::string& folder : folders) {
    STILLRAY_RETURN_IF_ERROR(SyncPath(folder, O_DIRECTORY));
  }
  return Status::Ok();
}

void RemoveStaleTemporaries(const std::string& folder) {
  std::error_code error;
  for (fs::directory_iterator entry(folder.empty() ? "." : folder, error), end;
       !error && entry != end; entry.increment(error)) {
    if (!IsTemporaryName(entry->path().filename().string())) {
      continue;
    }
    const std::string path = entry->path().string();
    const FileDescriptor file(::open(path.c_str(), O_RDWR | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC));
    struct stat info {};
    if (file.get() >= 0 && ::fstat(file.get(), &info) == 0 && S_ISREG(info.st_mode) &&
        ::flock(file.get(), LOCK_EX | LOCK_NB) == 0) {
      ::unlink(path.c_str());
    }
  }
}

}  // namespace stillray::io

namespace stillray {

Status WriteFileAtomically(const std::string& path, const void* bytes, size_t size) {
  return io::WriteWhole(path, bytes, size, false);
}

Result<std::string> ReadWholeFile(const std::string& path, size_t max_size) {
  // A pipe without a writer would block before the check of the file type.
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
    // One byte more than expected, so that the end of the file is detected without another read;
    // growing files take further reads.
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
