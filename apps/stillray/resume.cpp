// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "resume.h"

#include <cstring>
#include <filesystem>
#include <sstream>
#include <string_view>

#include <fmt/format.h>

#include "stillray/io.h"

namespace stillray {
namespace {

constexpr std::string_view kMagic = "stillray resume 1\n";
/// 16384 x 16384 pixels with four signals: no history is larger.
constexpr size_t kLargestFile = size_t{1} << 37;

void AppendNumber(uint64_t number, std::string* bytes) {
  char raw[sizeof(number)];
  std::memcpy(raw, &number, sizeof(number));
  bytes->append(raw, sizeof(number));
}

/// Takes the parts of the file off its front; fails for good at the first part that is cut short.
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
  bool complete() const { return !failed_ && rest_.empty(); }

 private:
  std::string_view rest_;
  bool failed_ = false;
};

}  // namespace

std::string ResumePath(const std::string& folder) {
  return (std::filesystem::path(folder) / "resume.stillray").string();
}

Status SaveResumeState(const std::string& folder, const ResumeState& state) {
  std::string bytes(kMagic);
  bytes.reserve(state.history.size() + state.log.size() + state.fingerprint.size() + 64);
  AppendNumber(static_cast<uint64_t>(state.last_frame), &bytes);
  for (const std::string* text : {&state.fingerprint, &state.log}) {
    AppendNumber(text->size(), &bytes);
    bytes += *text;
  }
  AppendNumber(state.history.size(), &bytes);
  bytes.append(reinterpret_cast<const char*>(state.history.data()), state.history.size());
  return WriteFileAtomically(ResumePath(folder), bytes.data(), bytes.size());
}

Result<ResumeState> LoadResumeState(const std::string& folder) {
  const std::string path = ResumePath(folder);
  Result<std::string> bytes = ReadWholeFile(path, kLargestFile);
  if (!bytes.ok()) {
    return bytes.status();
  }
  Reader reader(*bytes);
  const bool known = reader.Bytes(kMagic.size()) == kMagic;
  ResumeState state;
  state.last_frame = static_cast<int64_t>(reader.Number());
  state.fingerprint = reader.Block();
  state.log = reader.Block();
  const std::string_view history = reader.Block();
  if (!known || !reader.complete()) {
    return Status::BadData(fmt::format(
        "{} is damaged or of another version of stillray; remove it to start again", path));
  }
  state.history.assign(history.begin(), history.end());
  return state;
}

void RemoveResumeState(const std::string& folder) {
  std::error_code ignored;
  std::filesystem::remove(ResumePath(folder), ignored);
}

std::string FingerprintDifference(const std::string& made, const std::string& asked) {
  std::istringstream a(made);
  std::istringstream b(asked);
  std::string line_a;
  std::string line_b;
  while (true) {
    const bool more_a = static_cast<bool>(std::getline(a, line_a));
    const bool more_b = static_cast<bool>(std::getline(b, line_b));
    if (!more_a && !more_b) {
      return "";
    }
    if (more_a != more_b || line_a != line_b) {
      return fmt::format("it was made with '{}', this run has '{}'", more_a ? line_a : "",
                         more_b ? line_b : "");
    }
  }
}

}  // namespace stillray
