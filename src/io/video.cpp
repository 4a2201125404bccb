// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <new>
#include <system_error>

#include <fmt/format.h>

#include "io/atomic_file.h"
#include "io/frame_rate.h"
#include "io/text.h"
#include "stillray/io.h"

extern char** environ;

namespace stillray {

namespace io {

namespace {

constexpr int kMaxVideoSide = 16384;  // x264's limit
/// The encoder's output depends on the number of threads; a fixed number makes files identical on
/// all machines.
constexpr const char* kEncoderThreads = "4";
/// Near the threshold of visible loss.
constexpr const char* kQuality = "16";
/// Preset of x264. "medium" takes 2.5 times as long while frames are rendered in parallel, and its
/// files are as large.
constexpr const char* kPreset = "veryfast";

/// The descriptor of ffmpeg's output file.
constexpr int kOutputDescriptor = STDERR_FILENO + 1;

/// Duplicates the descriptor above those passed to ffmpeg, which may be free where a program runs
/// without a terminal. Closes `fd`.
int AboveOwnDescriptors(int fd) {
  const int above = ::fcntl(fd, F_DUPFD_CLOEXEC, kOutputDescriptor + 1);
  ::close(fd);
  return above;
}

/// An unnamed file for ffmpeg's messages; unlike a pipe it cannot fill up.
class MessageFile {
 public:
  MessageFile() {
    if (std::FILE* file = std::tmpfile(); file != nullptr) {
      fd_ = ::fcntl(::fileno(file), F_DUPFD_CLOEXEC, kOutputDescriptor + 1);
      std::fclose(file);
    }
  }
  MessageFile(const MessageFile&) = delete;
  MessageFile& operator=(const MessageFile&) = delete;
  ~MessageFile() {
    if (fd_ >= 0) {
      ::close(fd_);
    }
  }
  int fd() const { return fd_; }

  /// The system's reason why a file could not be written, which appears some lines before the end;
  /// empty if there is none.
  std::string WriteFailure() const {
    const std::string text = Tail();
    for (const int error : {ENOSPC, EDQUOT, EFBIG, EIO, EROFS}) {
      std::string reason = std::generic_category().message(error);
      if (text.find(": " + reason) != std::string::npos) {
        return reason;
      }
    }
    return {};
  }

  /// The most specific explanation of a failure: WriteFailure(), else the last non-empty line.
  std::string Explanation() const {
    const std::string failure = WriteFailure();
    const std::string text = failure.empty() ? Tail() : failure;
    const size_t line_end = text.rfind('\n');
    return line_end == std::string::npos ? text : text.substr(line_end + 1);
  }

 private:
  /// The last lines, without trailing blanks.
  std::string Tail() const {
    constexpr off_t kTail = 4096;
    const off_t end = ::lseek(fd_, 0, SEEK_END);
    std::string text(static_cast<size_t>(std::clamp<off_t>(end, 0, kTail)), '\0');
    const ssize_t got =
        ::pread(fd_, text.data(), text.size(), end - static_cast<off_t>(text.size()));
    text.resize(static_cast<size_t>(std::max<ssize_t>(got, 0)));
    for (char& c : text) {
      c = c == '\r' ? '\n' : c;
    }
    while (!text.empty() && (text.back() == '\n' || text.back() == ' ')) {
      text.pop_back();
    }
    return text;
  }

  int fd_ = -1;
};

/// Opens the file again, so that its lock ends with this process, not with ffmpeg.
int OpenAgain(int fd) {
  const int again = ::open(fmt::format("/proc/self/fd/{}", fd).c_str(), O_RDWR | O_CLOEXEC);
  return again >= 0 ? again : ::fcntl(fd, F_DUPFD_CLOEXEC, 0);
}

/// The name under which ffmpeg opens its output: the open file itself, since in a folder writable
/// by others the path could be replaced meanwhile. Without /proc, the path.
std::string OutputName(const std::string& path) {
  const std::string by_descriptor = fmt::format("/proc/self/fd/{}", kOutputDescriptor);
  return ::access("/proc/self/fd", X_OK) == 0 ? by_descriptor : path;
}

std::vector<std::string> Arguments(const std::string& output, int width, int height, double fps) {
  return {"ffmpeg", "-hide_banner", "-nostdin", "-loglevel", "error", "-y",
          // Input: raw frames.
          "-f", "rawvideo", "-pixel_format", "rgb24", "-video_size",
          fmt::format("{}x{}", width, height), "-framerate", fmt::format("{}", fps), "-i", "pipe:0",
          // Output.
          "-vf", "scale=out_color_matrix=bt709:out_range=tv:flags=accurate_rnd+full_chroma_int",
          "-c:v", "libx264", "-preset", kPreset, "-crf", kQuality, "-threads", kEncoderThreads,
          "-pix_fmt", "yuv420p", "-color_primaries", "bt709", "-color_trc", "bt709", "-colorspace",
          "bt709", "-color_range", "tv", "-fflags", "+bitexact", "-flags:v", "+bitexact",
          "-movflags", "+faststart", "-f", "mp4",
          // "file:" protects names with a colon or a leading dash.
          "file:" + output};
}

/// Starts ffmpeg with `input` as its standard input, in its own process group: Ctrl-C must reach
/// the calling program, which then closes the file properly. If that program is killed, ffmpeg
/// exits at the end of its input.
int Spawn(const std::vector<std::string>& arguments, int input, int output, int messages,
          pid_t* pid) {
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, input, STDIN_FILENO);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_adddup2(&actions, messages, STDERR_FILENO);
  posix_spawn_file_actions_adddup2(&actions, output, kOutputDescriptor);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t none;
  sigset_t defaults;
  sigemptyset(&none);
  sigemptyset(&defaults);
  for (const int signal : {SIGPIPE, SIGINT, SIGTERM}) {
    sigaddset(&defaults, signal);
  }
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setsigdefault(&attributes, &defaults);
  posix_spawnattr_setpgroup(&attributes, 0);
  posix_spawnattr_setflags(&attributes,
                           POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP);
  std::vector<char*> argv;
  for (const std::string& argument : arguments) {
    argv.push_back(const_cast<char*>(argument.c_str()));
  }
  argv.push_back(nullptr);
  const int error = posix_spawnp(pid, argv[0], &actions, &attributes, argv.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  return error;
}

class FfmpegWriter final : public VideoWriter {
 public:
  FfmpegWriter(std::string path, AtomicTarget target, int width, int height)
      : path_(std::move(path)), target_(std::move(target)), width_(width), height_(height) {}
  ~FfmpegWriter() override { Abandon(); }

  Status Start(double fps) {
    if (messages_.fd() < 0) {
      return Status::Io(fmt::format("{}: no temporary file could be made: {}", path_,
                                    std::generic_category().message(errno)));
    }
    Result<FileDescriptor> file = OpenTemporary(target_, path_);
    STILLRAY_RETURN_IF_ERROR(file.status());
    file_ = std::move(file.value());
    // A socket pair in place of a pipe: only sockets can report a closed reader without a signal to
    // the whole process.
    int ends[2];
    if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0) {
      return Status::Io(fmt::format("{}: no pipe to ffmpeg could be made: {}", path_,
                                    std::generic_category().message(errno)));
    }
    socket_ = AboveOwnDescriptors(ends[0]);
    const int input = AboveOwnDescriptors(ends[1]);
    const FileDescriptor output(AboveOwnDescriptors(OpenAgain(file_.get())));
    const int error =
        Spawn(Arguments(OutputName(target_.temp_path), Even(width_), Even(height_), fps), input,
              output.get(), messages_.fd(), &pid_);
    ::close(input);
    if (error != 0) {
      pid_ = -1;
      Abandon();
      return Status::Unsupported(fmt::format(
          "{}: ffmpeg could not be started ({}); install the package ffmpeg to write videos", path_,
          std::generic_category().message(error)));
    }
    return Status::Ok();
  }

  Status Write(const Rgb8Image& frame) override {
    STILLRAY_RETURN_IF_ERROR(status_);
    if (finished_) {
      return Status::InvalidArgument(fmt::format("{}: the video is already finished", path_));
    }
    const size_t expected = static_cast<size_t>(width_) * static_cast<size_t>(height_) * 3;
    if (frame.width != width_ || frame.height != height_ || frame.pixels.size() != expected) {
      return Status::InvalidArgument(
          fmt::format("{}: frame {} has {} x {} pixels in {} bytes; the video has {} x {}", path_,
                      frames_, frame.width, frame.height, frame.pixels.size(), width_, height_));
    }
    const std::vector<uint8_t>& padded = Pad(frame);
    if (!Send(padded.data(), padded.size())) {
      status_ = Failure(errno, Reap());
      return status_;
    }
    ++frames_;
    return Status::Ok();
  }

  Status Finish() override {
    STILLRAY_RETURN_IF_ERROR(status_);
    if (finished_) {
      return Status::Ok();
    }
    if (frames_ == 0) {
      Abandon();
      status_ = Status::InvalidArgument(fmt::format("{}: a video needs at least one frame", path_));
      return status_;
    }
    const int exit_status = Reap();
    struct stat info {};
    const bool written = ::fstat(file_.get(), &info) == 0 && info.st_size > 0;
    // -1: another part of this process reaped the child; then the file is checked instead. ffmpeg
    // returns 0 even if the last bytes of the file could not be written.
    if (exit_status > 0 || !written || !messages_.WriteFailure().empty() ||
        (exit_status < 0 && !messages_.Explanation().empty())) {
      status_ = Failure(0, exit_status);
      return status_;
    }
    status_ = CommitAtomicTarget(target_);
    finished_ = true;
    return status_;
  }

 private:
  static int Even(int size) { return size + size % 2; }

  const std::vector<uint8_t>& Pad(const Rgb8Image& frame) {
    if (width_ % 2 == 0 && height_ % 2 == 0) {
      return frame.pixels;
    }
    const size_t row_bytes = static_cast<size_t>(width_) * 3;
    const size_t padded_bytes = static_cast<size_t>(Even(width_)) * 3;
    padded_.resize(padded_bytes * static_cast<size_t>(Even(height_)));
    for (int y = 0; y < Even(height_); ++y) {
      const uint8_t* from =
          frame.pixels.data() + static_cast<size_t>(std::min(y, height_ - 1)) * row_bytes;
      uint8_t* to = padded_.data() + static_cast<size_t>(y) * padded_bytes;
      std::copy_n(from, row_bytes, to);
      std::copy_n(from + row_bytes - 3, padded_bytes - row_bytes, to + row_bytes);
    }
    return padded_;
  }

  bool Send(const uint8_t* bytes, size_t size) {
    while (size > 0) {
      const ssize_t sent = ::send(socket_, bytes, size, MSG_NOSIGNAL);
      if (sent < 0 && errno == EINTR) {
        continue;
      }
      if (sent < 0) {
        return false;
      }
      bytes += sent;
      size -= static_cast<size_t>(sent);
    }
    return true;
  }

  /// Ends ffmpeg's input and waits for it.
  /// \return its exit code; 128 + the signal that killed it; -1 if unknown
  int Reap() {
    if (socket_ >= 0) {
      ::close(socket_);
      socket_ = -1;
    }
    if (pid_ < 0) {
      return -1;
    }
    int status = 0;
    pid_t result;
    do {
      result = ::waitpid(pid_, &status, 0);
    } while (result < 0 && errno == EINTR);
    pid_ = -1;
    if (result < 0) {
      return -1;
    }
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }

  /// The error, in ffmpeg's words where available; removes the unfinished file.
  Status Failure(int error_number, int exit_status) {
    ::unlink(target_.temp_path.c_str());
    std::string reason = OneLine(messages_.Explanation());
    if (reason.empty()) {
      reason = exit_status > 0     ? fmt::format("it ended with code {}", exit_status)
               : error_number != 0 ? std::generic_category().message(error_number)
                                   : std::string("it wrote no file");
    }
    return Status::Io(fmt::format("{}: ffmpeg failed to write the video: {}", path_, reason));
  }

  void Abandon() {
    if (pid_ >= 0) {
      ::kill(pid_, SIGKILL);
    }
    Reap();
    if (!finished_ && !target_.temp_path.empty()) {
      ::unlink(target_.temp_path.c_str());
    }
  }

  std::string path_;
  AtomicTarget target_;
  int width_;
  int height_;
  MessageFile messages_;
  FileDescriptor file_;  ///< the temporary file, which ffmpeg also holds open
  int socket_ = -1;
  pid_t pid_ = -1;
  int64_t frames_ = 0;
  bool finished_ = false;
  Status status_;  ///< the first failure, which all later calls return again
  std::vector<uint8_t> padded_;
};

}  // namespace

}  // namespace io

Result<std::unique_ptr<VideoWriter>> VideoWriter::Create(const std::string& path, int width,
                                                         int height, double fps) {
  if (width < 1 || height < 1 || width > io::kMaxVideoSide || height > io::kMaxVideoSide) {
    return Status::InvalidArgument(
        fmt::format("{}: a video of {} x {} pixels cannot be written; 1 to {} a side can", path,
                    width, height, io::kMaxVideoSide));
  }
  if (!(fps >= kMinFps && fps <= kMaxFps)) {
    return Status::InvalidArgument(fmt::format(
        "{}: {} frames per second are not possible; {} to {} are", path, fps, kMinFps, kMaxFps));
  }
  Result<io::AtomicTarget> target = io::PrepareAtomicTarget(path);
  if (!target.ok()) {
    return target.status();
  }
  if (target->temp_path.empty()) {
    return Status::Unsupported(
        fmt::format("{}: a video can only be written to a regular file", path));
  }
  try {
    auto writer =
        std::make_unique<io::FfmpegWriter>(path, std::move(target).value(), width, height);
    STILLRAY_RETURN_IF_ERROR(writer->Start(fps));
    return std::unique_ptr<VideoWriter>(std::move(writer));
  } catch (const std::bad_alloc&) {
    return Status::OutOfMemory(fmt::format("{}: not enough memory to write a video", path));
  }
}

}  // namespace stillray
