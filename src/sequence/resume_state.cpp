// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "sequence/resume_state.h"

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "core/checksum.h"
#include "io/atomic_file.h"
#include "stillray/io.h"

namespace stillray {
namespace {

/// Followed by the checksum of the rest, then the key.
constexpr std::string_view kMagic = "stillray resume 3\n";
/// Common to all versions.
constexpr std::string_view kMagicOfAll = "stillray resume ";
/// 16384 x 16384 pixels with four signals: larger than any history.
constexpr size_t kLargestFile = size_t{1} << 37;
/// Maximum size of a key: names of files have at most 255 bytes.
constexpr size_t kLongestKey = 1000;
/// Further runs overwrite the last state.
constexpr int kMostStates = 64;

void AppendNumber(uint64_t number, std::string* bytes) {
  char raw[sizeof(number)];
  std::memcpy(raw, &number, sizeof(number));
  bytes->append(raw, sizeof(number));
}

/// Reads the parts of the file in order; fails permanently at the first truncated part.
class Reader {
 public:
  explicit Reader(std::string_view bytes) : rest_(bytes) {}

  uint64_t Number() {
    uint64_t number = 0;
    const std::string_view raw = Bytes(sizeof(number));
    if (raw.size() == sizeof(number)) {
      std::memcpy(&number, raw.data(), sizeof(number));
    }
    return number;
  }
  std::string_view Bytes(uint64_t size) {
    if (failed_ || size > rest_.size()) {
      failed_ = true;
      return {};
    }
    const std::string_view taken = rest_.substr(0, size);
    rest_.remove_prefix(size);
    return taken;
  }
  std::string_view Block() { return Bytes(Number()); }
  bool failed() const { return failed_; }
  bool complete() const { return !failed_ && rest_.empty(); }

 private:
  std::string_view rest_;
  bool failed_ = false;
};

void AppendText(std::string_view text, std::string* bytes) {
  AppendNumber(text.size(), bytes);
  *bytes += text;
}

void AppendFiles(const std::vector<FinishedFile>& files, std::string* bytes) {
  AppendNumber(files.size(), bytes);
  for (const FinishedFile& file : files) {
    AppendNumber(file.bytes, bytes);
    AppendNumber(file.checksum, bytes);
    AppendText(file.name, bytes);
  }
}

std::vector<FinishedFile> ReadFiles(Reader* reader) {
  std::vector<FinishedFile> files;
  const uint64_t count = reader->Number();
  for (uint64_t i = 0; i < count && !reader->failed(); ++i) {
    FinishedFile file;
    file.bytes = reader->Number();
    file.checksum = reader->Number();
    file.name = reader->Block();
    files.push_back(std::move(file));
  }
  return files;
}

void AppendPlane(const Image1& plane, std::string* bytes) {
  AppendNumber(static_cast<uint64_t>(plane.width()), bytes);
  AppendNumber(static_cast<uint64_t>(plane.height()), bytes);
  for (int y = 0; y < plane.height(); ++y) {
    bytes->append(reinterpret_cast<const char*>(plane.Row(y)),
                  static_cast<size_t>(plane.width()) * sizeof(float));
  }
}

Image1 ReadPlane(Reader* reader) {
  const uint64_t width = reader->Number();
  const uint64_t height = reader->Number();
  constexpr uint64_t kLargestSide = 32768;
  if (width > kLargestSide || height > kLargestSide || reader->failed()) {
    return {};
  }
  Image1 plane(static_cast<int>(width), static_cast<int>(height));
  for (int y = 0; y < plane.height(); ++y) {
    const std::string_view row = reader->Bytes(width * sizeof(float));
    std::memcpy(plane.Row(y), row.data(), row.size());
  }
  return plane;
}

void AppendUnwritten(const std::vector<UnwrittenFrame>& frames, std::string* bytes) {
  AppendNumber(frames.size(), bytes);
  for (const UnwrittenFrame& frame : frames) {
    AppendNumber(static_cast<uint64_t>(frame.frame), bytes);
    for (int c = 0; c < 3; ++c) {
      AppendPlane(frame.colour[c], bytes);
    }
    AppendNumber(frame.images.size(), bytes);
    for (const NamedImage& image : frame.images) {
      AppendText(image.name, bytes);
      AppendNumber(image.channels.size(), bytes);
      for (const Image1& channel : image.channels) {
        AppendPlane(channel, bytes);
      }
    }
  }
}

std::vector<UnwrittenFrame> ReadUnwritten(Reader* reader) {
  std::vector<UnwrittenFrame> frames;
  const uint64_t count = reader->Number();
  for (uint64_t i = 0; i < count && !reader->failed(); ++i) {
    UnwrittenFrame frame;
    frame.frame = static_cast<int64_t>(reader->Number());
    for (int c = 0; c < 3; ++c) {
      frame.colour[c] = ReadPlane(reader);
    }
    const uint64_t images = reader->Number();
    for (uint64_t k = 0; k < images && !reader->failed(); ++k) {
      NamedImage image;
      image.name = reader->Block();
      const uint64_t channels = reader->Number();
      for (uint64_t c = 0; c < channels && !reader->failed(); ++c) {
        image.channels.push_back(ReadPlane(reader));
      }
      frame.images.push_back(std::move(image));
    }
    frames.push_back(std::move(frame));
  }
  return frames;
}

uint64_t ChecksumOf(std::string_view bytes) {
  return AddToChecksum({reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size()});
}

/// The key of the state in a file; nullopt if there is no file, or it is of another version.
std::optional<std::string> KeyIn(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::string front(kMagic.size() + 2 * sizeof(uint64_t) + kLongestKey, '\0');
  file.read(front.data(), static_cast<std::streamsize>(front.size()));
  front.resize(static_cast<size_t>(file.gcount()));
  Reader reader(front);
  const bool known = reader.Bytes(kMagic.size()) == kMagic;
  reader.Number();
  std::string key(reader.Block());
  return known && !reader.failed() ? std::optional(std::move(key)) : std::nullopt;
}

/// The path of the n-th state, from 1.
std::string PlaceOf(const std::string& folder, int n) {
  const std::string name = n == 1 ? "resume.stillray" : fmt::format("resume.{}.stillray", n);
  return (std::filesystem::path(folder) / name).string();
}

Status Damaged(const std::string& path) {
  return Status::BadData(fmt::format("{} is damaged; remove it to start again", path));
}

}  // namespace

std::string ResumePath(const std::string& folder, const std::string& key) {
  std::string free_place;
  for (int n = 1; n <= kMostStates; ++n) {
    std::string path = PlaceOf(folder, n);
    const std::optional<std::string> found = KeyIn(path);
    if (found == key) {
      return path;
    }
    if (!found && free_place.empty()) {
      free_place = std::move(path);
    }
  }
  return free_place.empty() ? PlaceOf(folder, kMostStates) : free_place;
}

Status SaveResumeState(const std::string& folder, const ResumeState& state, size_t* synced) {
  std::vector<std::string> paths;
  for (size_t i = *synced; i < state.files.size(); ++i) {
    paths.push_back((std::filesystem::path(folder) / state.files[i].name).string());
  }
  STILLRAY_RETURN_IF_ERROR(io::SyncFiles(paths));
  *synced = state.files.size();
  std::string bytes(kMagic);
  bytes.reserve(state.history.size() + state.log.size() + state.fingerprint.size() +
                128 * (state.files.size() + state.inputs.size()) + 4096);
  AppendNumber(0, &bytes);
  AppendText(state.key, &bytes);
  AppendNumber(static_cast<uint64_t>(state.last_frame), &bytes);
  AppendText(state.fingerprint, &bytes);
  AppendText(state.log, &bytes);
  AppendFiles(state.inputs, &bytes);
  AppendFiles(state.files, &bytes);
  AppendUnwritten(state.unwritten, &bytes);
  AppendText({reinterpret_cast<const char*>(state.history.data()), state.history.size()}, &bytes);
  const uint64_t sum = ChecksumOf(std::string_view(bytes).substr(kMagic.size() + sizeof(uint64_t)));
  std::memcpy(bytes.data() + kMagic.size(), &sum, sizeof(sum));
  return io::WriteFileDurably(ResumePath(folder, state.key), bytes.data(), bytes.size());
}

Result<ResumeState> LoadResumeState(const std::string& folder, const std::string& key) {
  const std::string path = ResumePath(folder, key);
  Result<std::string> bytes = ReadWholeFile(path, kLargestFile);
  if (!bytes.ok()) {
    return bytes.status();
  }
  Reader reader(*bytes);
  const bool known = reader.Bytes(kMagic.size()) == kMagic;
  if (!known && bytes->starts_with(kMagicOfAll)) {
    return Status::BadData(path +
                           " was saved by another version of stillray; remove it to start "
                           "again");
  }
  const uint64_t sum = reader.Number();
  if (!known || reader.failed() ||
      sum != ChecksumOf(std::string_view(*bytes).substr(kMagic.size() + sizeof(uint64_t)))) {
    return Damaged(path);
  }
  ResumeState state;
  state.key = reader.Block();
  state.last_frame = static_cast<int64_t>(reader.Number());
  state.fingerprint = reader.Block();
  state.log = reader.Block();
  state.inputs = ReadFiles(&reader);
  state.files = ReadFiles(&reader);
  state.unwritten = ReadUnwritten(&reader);
  const std::string_view history = reader.Block();
  if (!reader.complete()) {
    return Damaged(path);
  }
  state.history.assign(history.begin(), history.end());
  return state;
}

void RemoveResumeState(const std::string& folder, const std::string& key) {
  std::error_code ignored;
  std::filesystem::remove(ResumePath(folder, key), ignored);
}

namespace {

std::vector<std::string> LinesOf(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) {
    lines.push_back(line);
  }
  return lines;
}

/// The name of a setting: the line up to its first space.
std::string_view NameOf(std::string_view line) {
  return line.substr(0, line.find(' '));
}

bool HasName(const std::vector<std::string>& lines, std::string_view name) {
  return std::any_of(lines.begin(), lines.end(),
                     [&](const std::string& line) { return NameOf(line) == name; });
}

}  // namespace

std::string FingerprintDifference(const std::string& made, const std::string& asked) {
  const std::vector<std::string> a = LinesOf(made);
  const std::vector<std::string> b = LinesOf(asked);
  const auto [in_a, in_b] = std::mismatch(a.begin(), a.end(), b.begin(), b.end());
  if (in_a == a.end() && in_b == b.end()) {
    return "";
  }
  // Versions of the program have different settings.
  if (in_b != b.end() && !HasName(a, NameOf(*in_b))) {
    return fmt::format("it was made without the setting '{}'", *in_b);
  }
  if (in_a != a.end() && !HasName(b, NameOf(*in_a))) {
    return fmt::format("it was made with '{}', a setting that this run does not have", *in_a);
  }
  return fmt::format("it was made with '{}', this run has '{}'", in_a != a.end() ? *in_a : "",
                     in_b != b.end() ? *in_b : "");
}

}  // namespace stillray
