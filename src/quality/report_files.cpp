// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "quality/report_files.h"

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <optional>
#include <string_view>
#include <system_error>

#include <fmt/core.h>

#include "core/lower_case.h"
#include "core/status_prefix.h"
#include "io/sequence.h"

namespace stillray::report {
namespace {

namespace fs = std::filesystem;

struct ParsedName {
  int view = 0;
  int64_t number = 0;
  bool exr = false;
};

/// Splits "denoised.0007.png"; nothing if the name has another form.
std::optional<ParsedName> ParseName(std::string_view name) {
  ParsedName parsed;
  if (name.ends_with(".exr")) {
    parsed.exr = true;
  } else if (!name.ends_with(".png")) {
    return std::nullopt;
  }
  name.remove_suffix(4);
  const size_t dot = name.find('.');
  if (dot == std::string_view::npos) {
    return std::nullopt;
  }
  const auto view = std::find(kViewNames.begin(), kViewNames.end(), name.substr(0, dot));
  if (view == kViewNames.end()) {
    return std::nullopt;
  }
  parsed.view = static_cast<int>(view - kViewNames.begin());
  const std::string_view digits = name.substr(dot + 1);
  const auto [end, error] =
      std::from_chars(digits.data(), digits.data() + digits.size(), parsed.number);
  if (error != std::errc() || end != digits.data() + digits.size()) {
    return std::nullopt;
  }
  return parsed;
}

Status AddFile(const std::string& path, const ParsedName& name, SequenceFiles* files) {
  PictureFiles& picture = (*files)[name.number][static_cast<size_t>(name.view)];
  std::string& slot = name.exr ? picture.exr : picture.png;
  if (!slot.empty()) {
    // The order of a folder's files is arbitrary; the message must not depend on it.
    return Status::BadData(
        fmt::format("{} and {} are the same frame", std::min(slot, path), std::max(slot, path)));
  }
  slot = path;
  return Status::Ok();
}

}  // namespace

Result<SequenceFiles> FindSequence(const std::string& folder) {
  std::error_code error;
  if (!fs::exists(folder, error)) {
    return Status::NotFound(fmt::format("{}: no such folder", folder));
  }
  if (!fs::is_directory(folder, error)) {
    return Status::NotFound(
        fmt::format("{}: not a folder; expected what stillray render left", folder));
  }
  SequenceFiles files;
  fs::directory_iterator entry(folder, error);
  for (; !error && entry != fs::directory_iterator(); entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    if (const std::optional<ParsedName> parsed = ParseName(name)) {
      STILLRAY_RETURN_IF_ERROR(AddFile(entry->path().string(), *parsed, &files));
    }
  }
  if (error) {
    return Status::Io(fmt::format("{}: cannot be listed: {}", folder, error.message()));
  }
  if (files.empty()) {
    return Status::NotFound(fmt::format(
        "{}: no frames; expected files such as denoised.0001.png or noisy.0001.exr", folder));
  }
  return files;
}

Result<SequenceFiles> FindViews(const std::string& noisy, const std::string& clean,
                                const std::string& reference) {
  static constexpr std::string_view kEndings[] = {".exr", ".png"};
  struct Named {
    View view;
    const char* option;
    const std::string& name;
  };
  SequenceFiles frames;
  // The clean sequence first: it determines the frames.
  for (const Named& named : {Named{kDenoised, "--clean", clean}, Named{kNoisy, "--noisy", noisy},
                             Named{kReference, "--reference", reference}}) {
    if (named.name.empty()) {
      continue;
    }
    const Result<std::vector<FrameFile>> found = FindFrameFiles(named.name, kEndings);
    if (!found.ok()) {
      return PrefixStatus(named.option, found.status());
    }
    for (const FrameFile& file : *found) {
      const bool png = LowerExtension(file.path) == ".png";
      if (!png && LowerExtension(file.path) != ".exr") {
        return Status::InvalidArgument(
            fmt::format("{}: {} is no EXR and no PNG file by its name", named.option, file.path));
      }
      if (named.view != kDenoised && frames.count(file.frame) == 0) {
        continue;
      }
      PictureFiles& picture = frames[file.frame][static_cast<size_t>(named.view)];
      (png ? picture.png : picture.exr) = file.path;
    }
  }
  return frames;
}

std::vector<int> SpreadEvenly(int total, int count) {
  std::vector<int> chosen;
  if (count >= total) {
    count = total;
  }
  if (count == 1) {
    return {total - 1};
  }
  for (int64_t i = 0; i < count; ++i) {
    // Rounded to the nearest; count <= total keeps neighbours apart.
    chosen.push_back(static_cast<int>((2 * i * (total - 1) + (count - 1)) / (2 * (count - 1))));
  }
  return chosen;
}

std::string JoinNames(const std::vector<std::string>& names) {
  std::string text;
  for (size_t i = 0; i < names.size(); ++i) {
    text += i == 0 ? "" : i + 1 == names.size() ? " and " : ", ";
    text += names[i];
  }
  return text;
}

}  // namespace stillray::report
