// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "sequence/list_sequence.h"

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <optional>
#include <set>
#include <string_view>

#include <fmt/format.h>

#include "core/lower_case.h"
#include "io/sequence.h"
#include "stillray/io.h"
#include "stillray/sequence.h"

namespace stillray {
namespace {

namespace fs = std::filesystem;

struct Range {
  int64_t first = INT64_MIN;
  int64_t last = INT64_MAX;
};

constexpr std::string_view kExr[] = {".exr"};

/// Extensions that are not folder names: the user wants another kind of file.
constexpr std::string_view kOtherKinds[] = {".png", ".jpg", ".jpeg", ".tif", ".tiff",
                                            ".hdr", ".mp4", ".mov",  ".exr"};

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

/// In the given order. Frame numbers are those of the names if all names have a number and these
/// increase.
std::vector<SequenceFile> FilesOfList(const std::vector<std::string>& inputs) {
  std::vector<SequenceFile> files;
  bool numbered = true;
  for (const std::string& input : inputs) {
    const std::optional<int64_t> number = FrameNumberIn(input);
    numbered = numbered && number && (files.empty() || *number > files.back().frame);
    files.push_back({number.value_or(0), input, ""});
  }
  for (size_t i = 0; i < files.size() && !numbered; ++i) {
    files[i].frame = static_cast<int64_t>(i) + 1;
  }
  return files;
}

Result<std::vector<SequenceFile>> FindInputs(const std::vector<std::string>& inputs) {
  std::error_code ignored;
  if (inputs.size() == 1 &&
      (!fs::exists(inputs[0], ignored) || fs::is_directory(inputs[0], ignored))) {
    Result<std::vector<FrameFile>> found = FindFrameFiles(inputs[0], kExr);
    if (!found.ok()) {
      return found.status();
    }
    std::vector<SequenceFile> files;
    for (FrameFile& file : found.value()) {
      files.push_back({file.frame, std::move(file.path), ""});
    }
    return files;
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

Status NameOutputs(const std::string& text, std::vector<SequenceFile>* files) {
  std::error_code ignored;
  const bool folder = IsFolderName(text);
  const std::string output = folder ? text : AsFramePattern(text);
  if (!folder && LowerExtension(output) != ".exr") {
    return Status::InvalidArgument(fmt::format(
        "-o is '{}', expected a name that ends in .exr, or a folder: files keep their layers; "
        "--preview {} writes pictures to look at",
        text, text));
  }
  if (!folder && !IsFramePattern(output) && files->size() > 1) {
    return Status::InvalidArgument(
        fmt::format("-o is '{}', expected a pattern such as out.####.exr or a folder for {} frames",
                    text, files->size()));
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

bool IsFolderName(const std::string& output) {
  std::error_code ignored;
  const std::string ending = LowerExtension(output);
  const bool other_kind =
      std::find(std::begin(kOtherKinds), std::end(kOtherKinds), ending) != std::end(kOtherKinds);
  return output.ends_with('/') || fs::is_directory(output, ignored) ||
         (!other_kind && !IsSequenceName(output));
}

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

Window ChooseWindow(const std::vector<SequenceFile>& files, std::string* note) {
  if (files.size() < 2) {
    return Window::kPast;
  }
  const auto gap = std::adjacent_find(
      files.begin(), files.end(),
      [](const SequenceFile& a, const SequenceFile& b) { return b.frame != a.frame + 1; });
  if (gap == files.end()) {
    return Window::kBoth;
  }
  *note = fmt::format(
      "--window past, as frames are missing between {} and {}; --window both looks ahead up to "
      "every gap",
      gap->frame, (gap + 1)->frame);
  return Window::kPast;
}

}  // namespace stillray
