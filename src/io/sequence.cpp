// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "io/sequence.h"

#include <fnmatch.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string_view>
#include <system_error>
#include <tuple>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/lower_case.h"
#include "core/status_prefix.h"
#include "io/text.h"
#include "stillray/io.h"

namespace stillray {

namespace {

namespace fs = std::filesystem;

constexpr int kMaxDigits = 18;  // so that every number fits into int64_t

/// A pattern split at its marks.
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
  // Unsigned negation, which also works for the smallest int64_t.
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
  // Exactly as FrameFileName writes it: "7" and "0007" are frames of different patterns.
  return NumberText(number, digits) == text ? std::optional(number) : std::nullopt;
}

bool IsDigit(char c) {
  return c >= '0' && c <= '9';
}

/// A file name split at its last run of digits; digits of the extension do not count.
struct NumberedName {
  std::string before;
  std::string digits;
  std::string after;
  int64_t number = 0;
};

std::optional<NumberedName> CutAtNumber(const std::string& name) {
  const size_t dot = name.rfind('.');
  size_t end = dot == std::string::npos ? name.size() : dot;
  while (end > 0 && !IsDigit(name[end - 1])) {
    --end;
  }
  size_t begin = end;
  while (begin > 0 && IsDigit(name[begin - 1]) && end - begin < kMaxDigits) {
    --begin;
  }
  if (begin == end) {
    return std::nullopt;
  }
  NumberedName cut{name.substr(0, begin), name.substr(begin, end - begin), name.substr(end), 0};
  std::from_chars(cut.digits.data(), cut.digits.data() + cut.digits.size(), cut.number);
  return cut;
}

/// One sequence of a folder.
struct FoundSequence {
  std::vector<FrameFile> files;  ///< sorted by frame, then by path
  std::string pattern;           ///< of the file names
};

bool HasWildCards(const std::string& name) {
  return name.find_first_of("*?") != std::string::npos;
}

/// The folder and pattern of a name given by the user.
struct NamedPlace {
  fs::path folder;
  std::string shown;  ///< the folder as typed, with its slash; empty for the current one
  std::string name;
};

NamedPlace PlaceOf(const std::string& path) {
  const size_t slash = path.rfind('/');
  const size_t name_begin = slash == std::string::npos ? 0 : slash + 1;
  const std::string shown = path.substr(0, name_begin);
  return {shown.empty() ? fs::path(".") : fs::path(shown), shown, path.substr(name_begin)};
}

/// All sequences of a folder whose file names match, in the order of their names.
Result<std::vector<FoundSequence>> ListSequences(
    const NamedPlace& place, const std::function<bool(const std::string& name)>& wanted) {
  std::map<std::pair<std::string, std::string>, FoundSequence> sequences;
  std::map<std::pair<std::string, std::string>, size_t> widths;
  std::error_code error;
  for (fs::directory_iterator it(place.folder, error), end; !error && it != end;
       it.increment(error)) {
    const std::string name = it->path().filename().string();
    const std::optional<NumberedName> cut = CutAtNumber(name);
    std::error_code ignored;
    if (!cut || !wanted(name) || it->is_directory(ignored)) {
      continue;
    }
    const std::pair key(cut->before, cut->after);
    sequences[key].files.push_back({cut->number, place.shown + name});
    const auto width = widths.emplace(key, cut->digits.size()).first;
    width->second = std::min(width->second, cut->digits.size());
  }
  if (error) {
    return Status(
        error == std::errc::no_such_file_or_directory ? StatusCode::kNotFound : StatusCode::kIo,
        fmt::format("the folder {} cannot be listed: {}", io::OneLine(place.folder.string()),
                    error.message()));
  }
  std::vector<FoundSequence> found;
  for (auto& [key, sequence] : sequences) {
    sequence.pattern = key.first + std::string(widths[key], '#') + key.second;
    std::sort(sequence.files.begin(), sequence.files.end(),
              [](const FrameFile& a, const FrameFile& b) {
                return std::tie(a.frame, a.path) < std::tie(b.frame, b.path);
              });
    found.push_back(std::move(sequence));
  }
  return found;
}

bool HasEnding(const std::string& name, FileEndings endings) {
  return std::find(endings.begin(), endings.end(), LowerExtension(name)) != endings.end();
}

/// Length of the common prefix of two names.
size_t CommonBegin(const std::string& a, const std::string& b) {
  const auto [end, ignored] = std::mismatch(a.begin(), a.end(), b.begin(), b.end());
  return static_cast<size_t>(end - a.begin());
}

std::string NameOf(const std::string& path) {
  return io::OneLine(fs::path(path).filename().string());
}

/// "; found shot.0001.exr ... shot.0016.exr: did you mean shot.####.exr?" Of several sequences, the
/// one with the longest common prefix.
std::string Suggestion(const NamedPlace& place, FileEndings endings) {
  const Result<std::vector<FoundSequence>> all =
      ListSequences(place, [&](const std::string& name) { return HasEnding(name, endings); });
  if (!all.ok()) {
    return "; " + all.status().message();
  }
  if (all->empty()) {
    return fmt::format("; there are no numbered files of kind {} in {}", fmt::join(endings, ", "),
                       place.shown.empty() ? "this folder" : io::OneLine(place.shown));
  }
  const FoundSequence& best = *std::max_element(
      all->begin(), all->end(), [&](const FoundSequence& a, const FoundSequence& b) {
        return CommonBegin(a.pattern, place.name) < CommonBegin(b.pattern, place.name);
      });
  const std::string first = NameOf(best.files.front().path);
  const std::string files =
      best.files.size() == 1 ? first : first + " ... " + NameOf(best.files.back().path);
  return fmt::format("; found {}: did you mean {}{}?", files, io::OneLine(place.shown),
                     io::OneLine(best.pattern));
}

Status SeveralSequences(const std::string& input, const NamedPlace& place,
                        const std::vector<FoundSequence>& found) {
  constexpr size_t kListed = 8;
  std::vector<std::string> names;
  for (size_t i = 0; i < std::min(found.size(), kListed); ++i) {
    names.push_back(
        fmt::format("{} ({} files)", io::OneLine(found[i].pattern), found[i].files.size()));
  }
  if (found.size() > kListed) {
    names.push_back(fmt::format("{} more", found.size() - kListed));
  }
  return Status::InvalidArgument(
      fmt::format("{}: {} {} sequences, name one of them by a pattern such as {}{}: {}", input,
                  HasWildCards(place.name) ? "matches" : "holds", found.size(), place.shown,
                  io::OneLine(found.front().pattern), fmt::join(names, ", ")));
}

/// The only sequence found; an error if there are several.
Result<std::vector<FrameFile>> OnlySequence(const std::string& input, const NamedPlace& place,
                                            std::vector<FoundSequence> found) {
  if (found.size() > 1) {
    return SeveralSequences(input, place, found);
  }
  std::vector<FrameFile>& files = found.front().files;
  const auto twice =
      std::adjacent_find(files.begin(), files.end(),
                         [](const FrameFile& a, const FrameFile& b) { return a.frame == b.frame; });
  if (twice != files.end()) {
    return Status::InvalidArgument(fmt::format("{}: {} and {} are the same frame", input,
                                               NameOf(twice->path), NameOf((twice + 1)->path)));
  }
  return std::move(files);
}

Result<std::vector<FrameFile>> FilesOfFolder(const std::string& folder, FileEndings endings) {
  const NamedPlace place = PlaceOf(folder.ends_with('/') ? folder : folder + "/");
  Result<std::vector<FoundSequence>> found =
      ListSequences(place, [&](const std::string& name) { return HasEnding(name, endings); });
  if (!found.ok()) {
    return PrefixStatus(folder, found.status());
  }
  if (found->empty()) {
    return Status::NotFound(
        fmt::format("{}: holds no numbered files of kind {}", folder, fmt::join(endings, ", ")));
  }
  return OnlySequence(folder, place, std::move(found.value()));
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

bool IsSequenceName(const std::string& path) {
  return IsFramePattern(path) || HasWildCards(PlaceOf(path).name);
}

std::string AsFramePattern(const std::string& path) {
  const NamedPlace place = PlaceOf(path);
  if (IsFramePattern(path) || !HasWildCards(place.name)) {
    return path;
  }
  std::string name;
  for (const char c : place.name) {
    name += c == '*' ? "####" : c == '?' ? "#" : std::string(1, c);
  }
  return place.shown + name;
}

std::optional<int64_t> FrameNumberIn(const std::string& path) {
  const std::optional<NumberedName> cut = CutAtNumber(PlaceOf(path).name);
  return cut ? std::optional(cut->number) : std::nullopt;
}

Result<std::vector<FrameFile>> FindFrameFiles(const std::string& input, FileEndings endings) {
  std::error_code ignored;
  if (fs::is_directory(input, ignored)) {
    return FilesOfFolder(input, endings);
  }
  std::vector<FrameFile> files;
  for (const int64_t frame : FindFrames(input)) {
    files.push_back({frame, FrameFileName(input, frame)});
  }
  if (!files.empty()) {
    return files;
  }
  const NamedPlace place = PlaceOf(input);
  const std::optional<PatternParts> parts = SplitPattern(input);
  const bool wild = !parts && HasWildCards(place.name);
  if (parts || wild) {
    Result<std::vector<FoundSequence>> found = ListSequences(place, [&](const std::string& name) {
      if (wild) {
        return HasEnding(name, endings) && fnmatch(place.name.c_str(), name.c_str(), 0) == 0;
      }
      const std::optional<NumberedName> cut = CutAtNumber(name);
      return cut->before == parts->before && cut->after == parts->after;
    });
    if (found.ok() && !found->empty()) {
      return OnlySequence(input, place, std::move(found.value()));
    }
  }
  return Status::NotFound(fmt::format(
      "{}: {}{}", input, parts || wild ? "no file matches this pattern" : "no such file",
      Suggestion(place, endings)));
}

}  // namespace stillray
