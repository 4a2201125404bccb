// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise_inputs.h"

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <map>
#include <optional>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/lower_case.h"
#include "stillray/io.h"

namespace stillray {
namespace {

namespace fs = std::filesystem;

struct Range {
  int64_t first = INT64_MIN;
  int64_t last = INT64_MAX;
};

bool IsDigit(char c) {
  return c >= '0' && c <= '9';
}

/// The last run of digits in a file's own name: where it stands and what it says.
struct NumberInName {
  size_t begin = 0;
  size_t end = 0;
  int64_t number = 0;
};
std::optional<NumberInName> FindNumber(const std::string& name) {
  constexpr size_t kMaxDigits = 18;  // so that every number fits into int64_t
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
  NumberInName found{begin, end, 0};
  std::from_chars(name.data() + begin, name.data() + end, found.number);
  return found;
}

bool HasExrEnding(const fs::path& path) {
  return LowerExtension(path) == ".exr";
}

Result<Range> ParseFrames(const std::string& text) {
  Range range;
  if (text.empty()) {
    return range;
  }
  const auto parse = [](std::string_view part, int64_t* out) {
    const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), *out);
    return error == std::errc() && end == part.data() + part.size();
  };
  // A leading minus belongs to the number.
  const size_t dash = text.find('-', 1);
  bool parsed = parse(std::string_view(text).substr(0, dash), &range.first);
  range.last = range.first;
  if (dash != std::string::npos) {
    parsed = parsed && parse(std::string_view(text).substr(dash + 1), &range.last);
  }
  if (!parsed || range.last < range.first) {
    return Status::InvalidArgument(
        fmt::format("--frames is '{}', expected FIRST-LAST or one number, such as 1-24", text));
  }
  return range;
}

Result<std::vector<SequenceFile>> FilesOfPattern(const std::string& pattern) {
  std::vector<SequenceFile> files;
  for (const int64_t frame : FindFrames(pattern)) {
    files.push_back({frame, FrameFileName(pattern, frame), ""});
  }
  if (files.empty()) {
    return Status::NotFound(fmt::format("{}: no file matches this pattern", pattern));
  }
  return files;
}

Result<std::vector<SequenceFile>> FilesOfFolder(const std::string& folder) {
  std::map<std::string, std::vector<SequenceFile>> sequences;
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    const std::string name = it->path().filename().string();
    const std::optional<NumberInName> number = FindNumber(name);
    if (HasExrEnding(it->path()) && number) {
      const std::string pattern = name.substr(0, number->begin) + "#" + name.substr(number->end);
      sequences[pattern].push_back({number->number, it->path().string(), ""});
    }
  }
  if (error) {
    return Status::Io(fmt::format("{}: cannot be listed: {}", folder, error.message()));
  }
  if (sequences.empty()) {
    return Status::NotFound(fmt::format("{}: holds no numbered .exr files", folder));
  }
  if (sequences.size() > 1) {
    std::vector<std::string> names;
    for (const auto& [pattern, files] : sequences) {
      names.push_back(fmt::format("{} ({} files)", pattern, files.size()));
    }
    return Status::InvalidArgument(fmt::format(
        "{}: holds {} sequences, name one of them by a pattern such as {}/name.####.exr: {}",
        folder, sequences.size(), folder, fmt::join(names, ", ")));
  }
  std::vector<SequenceFile> files = std::move(sequences.begin()->second);
  std::sort(files.begin(), files.end(),
            [](const SequenceFile& a, const SequenceFile& b) { return a.frame < b.frame; });
  return files;
}

/// In the order given. Numbers come from the names if all have one and they rise.
std::vector<SequenceFile> FilesOfList(const std::vector<std::string>& inputs) {
  std::vector<SequenceFile> files;
  bool numbered = true;
  for (const std::string& input : inputs) {
    const std::optional<NumberInName> number = FindNumber(fs::path(input).filename().string());
    numbered = numbered && number && (files.empty() || number->number > files.back().frame);
    files.push_back({number ? number->number : 0, input, ""});
  }
  for (size_t i = 0; i < files.size() && !numbered; ++i) {
    files[i].frame = static_cast<int64_t>(i) + 1;
  }
  return files;
}

Result<std::vector<SequenceFile>> FindInputs(const std::vector<std::string>& inputs) {
  std::error_code ignored;
  if (inputs.size() == 1 && fs::is_directory(inputs[0], ignored)) {
    return FilesOfFolder(inputs[0]);
  }
  if (inputs.size() == 1 && !fs::exists(inputs[0], ignored) && IsFramePattern(inputs[0])) {
    return FilesOfPattern(inputs[0]);
  }
  for (const std::string& input : inputs) {
    if (!fs::exists(input, ignored)) {
      return Status::NotFound(fmt::format("{}: no such file", input));
    }
    if (fs::is_directory(input, ignored)) {
      return Status::InvalidArgument(
          fmt::format("{}: is a folder, expected a file in a list of files", input));
    }
  }
  return FilesOfList(inputs);
}

Status NameOutputs(const std::string& output, std::vector<SequenceFile>* files) {
  std::error_code ignored;
  const bool folder = output.ends_with('/') || fs::is_directory(output, ignored);
  if (!folder && !IsFramePattern(output) && files->size() > 1) {
    return Status::InvalidArgument(
        fmt::format("-o is '{}', expected a pattern such as out.####.exr or a folder for {} frames",
                    output, files->size()));
  }
  if (!folder && !HasExrEnding(output)) {
    return Status::InvalidArgument(fmt::format(
        "-o is '{}', expected a name that ends in .exr: files are written as they came", output));
  }
  std::set<std::string> taken;
  std::set<std::string> inputs;
  for (const SequenceFile& file : *files) {
    inputs.insert(fs::weakly_canonical(file.input, ignored).string());
  }
  for (SequenceFile& file : *files) {
    file.output = folder ? (fs::path(output) / fs::path(file.input).filename()).string()
                         : FrameFileName(output, file.frame);
    const std::string place = fs::weakly_canonical(file.output, ignored).string();
    if (inputs.count(place) != 0) {
      return Status::InvalidArgument(
          fmt::format("-o '{}' would overwrite the input {}", output, file.output));
    }
    if (!taken.insert(place).second) {
      return Status::InvalidArgument(
          fmt::format("-o '{}' would write {} twice", output, file.output));
    }
  }
  return Status::Ok();
}

}  // namespace

Result<std::vector<SequenceFile>> ListSequence(const std::vector<std::string>& inputs,
                                               const std::string& output,
                                               const std::string& frames) {
  const Result<Range> range = ParseFrames(frames);
  if (!range.ok()) {
    return range.status();
  }
  Result<std::vector<SequenceFile>> files = FindInputs(inputs);
  if (!files.ok()) {
    return files;
  }
  const size_t found = files->size();
  const int64_t first = files->front().frame;
  const int64_t last = files->back().frame;
  std::erase_if(*files, [&](const SequenceFile& file) {
    return file.frame < range->first || file.frame > range->last;
  });
  if (files->empty()) {
    return Status::NotFound(fmt::format("--frames is '{}', the {} files found are frames {} to {}",
                                        frames, found, first, last));
  }
  STILLRAY_RETURN_IF_ERROR(NameOutputs(output, &*files));
  return files;
}

}  // namespace stillray
