// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <charconv>
#include <filesystem>
#include <optional>
#include <string_view>
#include <system_error>

#include <fmt/format.h>

#include "stillray/io.h"

namespace stillray {

namespace {

namespace fs = std::filesystem;

constexpr int kMaxDigits = 18;  // so that every number fits into int64_t

/// A pattern cut at its marks.
struct PatternParts {
  std::string folder;  ///< with its slash, or empty
  std::string before;
  std::string after;
  int digits = 1;
};

std::optional<PatternParts> SplitPattern(const std::string& pattern) {
  const size_t slash = pattern.rfind('/');
  const size_t name_begin = slash == std::string::npos ? 0 : slash + 1;
  const std::string name = pattern.substr(name_begin);
  PatternParts parts;
  parts.folder = pattern.substr(0, name_begin);
  const size_t last_mark = name.rfind('#');
  if (last_mark != std::string::npos) {
    size_t first_mark = last_mark;
    while (first_mark > 0 && name[first_mark - 1] == '#') {
      --first_mark;
    }
    parts.digits = static_cast<int>(std::min<size_t>(last_mark - first_mark + 1, kMaxDigits));
    parts.before = name.substr(0, first_mark);
    parts.after = name.substr(last_mark + 1);
    return parts;
  }
  for (size_t percent = name.rfind('%'); percent != std::string::npos;
       percent = percent == 0 ? std::string::npos : name.rfind('%', percent - 1)) {
    size_t end = percent + 1;
    while (end < name.size() && name[end] >= '0' && name[end] <= '9') {
      ++end;
    }
    if (end >= name.size() || name[end] != 'd') {
      continue;
    }
    int digits = 1;
    if (std::from_chars(name.data() + percent + 1, name.data() + end, digits).ec ==
        std::errc::result_out_of_range) {
      digits = kMaxDigits;
    }
    parts.digits = std::clamp(digits, 1, kMaxDigits);
    parts.before = name.substr(0, percent);
    parts.after = name.substr(end + 1);
    return parts;
  }
  return std::nullopt;
}

std::string NumberText(int64_t frame, int digits) {
  // Unsigned negation, so that the least int64_t has its magnitude too.
  const uint64_t magnitude =
      frame < 0 ? uint64_t{0} - static_cast<uint64_t>(frame) : static_cast<uint64_t>(frame);
  return fmt::format("{}{:0{}}", frame < 0 ? "-" : "", magnitude, digits);
}

std::optional<int64_t> ParseNumber(std::string_view text, int digits) {
  int64_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size()) {
    return std::nullopt;
  }
  // Exactly as FrameFileName would write it: "7" and "0007" are frames of different patterns.
  return NumberText(number, digits) == text ? std::optional(number) : std::nullopt;
}

}  // namespace

std::string FrameFileName(const std::string& pattern, int64_t frame) {
  const std::optional<PatternParts> parts = SplitPattern(pattern);
  if (!parts) {
    return pattern;
  }
  return parts->folder + parts->before + NumberText(frame, parts->digits) + parts->after;
}

bool IsFramePattern(const std::string& path) {
  return SplitPattern(path).has_value();
}

std::vector<int64_t> FindFrames(const std::string& pattern) {
  const std::optional<PatternParts> parts = SplitPattern(pattern);
  std::vector<int64_t> frames;
  if (!parts) {
    return frames;
  }
  const fs::path folder = parts->folder.empty() ? fs::path(".") : fs::path(parts->folder);
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    const std::string name = it->path().filename().string();
    const size_t fixed = parts->before.size() + parts->after.size();
    if (name.size() <= fixed || !name.starts_with(parts->before) || !name.ends_with(parts->after)) {
      continue;
    }
    const std::string_view number =
        std::string_view(name).substr(parts->before.size(), name.size() - fixed);
    std::error_code ignored;
    if (const auto frame = ParseNumber(number, parts->digits);
        frame && !it->is_directory(ignored)) {
      frames.push_back(*frame);
    }
  }
  std::sort(frames.begin(), frames.end());
  return frames;
}

}  // namespace stillray
