// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "common/settings_file.h"

#include <fmt/format.h>

#include "core/parameter_table.h"
#include "stillray/io.h"

namespace stillray {
namespace {

constexpr size_t kLargestFile = 1 << 20;
constexpr std::string_view kRenderPrefix = "render.";

std::string_view Trim(std::string_view text) {
  constexpr std::string_view kSpace = " \t\r";
  const size_t begin = text.find_first_not_of(kSpace);
  if (begin == std::string_view::npos) {
    return {};
  }
  return text.substr(begin, text.find_last_not_of(kSpace) - begin + 1);
}

Status AddRenderLine(std::string_view name, std::string_view value, RenderLines* lines) {
  RenderSettings scratch;
  const Status set = SetRenderParameter(&scratch, name, value);
  if (set.ok()) {
    lines->push_back({std::string(name), std::string(value)});
    return set;
  }
  const bool known = GetRenderParameter(scratch, name).ok();
  return Status::BadData(known ? fmt::format("{}{}", kRenderPrefix, set.message())
                               : fmt::format("{}{}: {}", kRenderPrefix, name, set.message()));
}

Status SetLine(std::string_view line, bool first, SettingsFile* file) {
  std::string_view name;
  std::string_view value;
  STILLRAY_RETURN_IF_ERROR(SplitAssignment(line, &name, &value));
  name = Trim(name);
  value = Trim(value);
  if (name == "preset") {
    if (!first) {
      return Status::BadData("preset comes after other settings, expected it before all");
    }
    Result<Settings> preset = PresetSettings(value);
    if (preset.ok()) {
      file->preset = std::string(value);
      file->denoise = preset.value();
    }
    return preset.status();
  }
  if (name.substr(0, kRenderPrefix.size()) == kRenderPrefix) {
    return AddRenderLine(name.substr(kRenderPrefix.size()), value, &file->render);
  }
  return SetParameter(&file->denoise, name, value);
}

}  // namespace

Result<SettingsFile> ParseSettingsFile(std::string_view text, const std::string& name) {
  SettingsFile file;
  int number = 0;
  bool first = true;
  while (!text.empty()) {
    ++number;
    const size_t end = text.find('\n');
    const std::string_view line = Trim(text.substr(0, end));
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    if (line.empty() || line.front() == '#') {
      continue;
    }
    const Status status = SetLine(line, first, &file);
    if (!status.ok()) {
      return Status::BadData(fmt::format("{}:{}: {}", name, number, status.message()));
    }
    first = false;
  }
  const Status valid = ValidateSettings(file.denoise);
  return valid.ok() ? Result<SettingsFile>(std::move(file))
                    : Status::BadData(fmt::format("{}: {}", name, valid.message()));
}

Result<SettingsFile> ReadSettingsFile(const std::string& path) {
  const Result<std::string> text = ReadWholeFile(path, kLargestFile);
  return text.ok() ? ParseSettingsFile(text.value(), path) : Result<SettingsFile>(text.status());
}

Status ApplyRenderLines(const RenderLines& lines, RenderSettings* settings) {
  for (const RenderLine& line : lines) {
    STILLRAY_RETURN_IF_ERROR(SetRenderParameter(settings, line.name, line.value));
  }
  return Status::Ok();
}

Result<std::vector<std::string>> ChangedParameters(const SettingsFile& settings) {
  const Result<Settings> preset = PresetSettings(settings.preset);
  STILLRAY_RETURN_IF_ERROR(preset.status());
  STILLRAY_RETURN_IF_ERROR(ValidateSettings(settings.denoise));
  std::vector<std::string> changed;
  for (const Parameter& p : Parameters()) {
    if (GetParameter(settings.denoise, p.name).value() != GetParameter(*preset, p.name).value()) {
      changed.emplace_back(p.name);
    }
  }
  return changed;
}

Result<std::string> FormatSettingsFile(const SettingsFile& settings) {
  const Result<std::vector<std::string>> changed = ChangedParameters(settings);
  STILLRAY_RETURN_IF_ERROR(changed.status());
  std::string text = fmt::format("# stillray settings\npreset={}\n", settings.preset);
  for (const std::string& name : *changed) {
    text += fmt::format("{}={}\n", name, GetParameter(settings.denoise, name).value());
  }
  for (const RenderLine& line : settings.render) {
    text += fmt::format("{}{}={}\n", kRenderPrefix, line.name, line.value);
  }
  return text;
}

Status WriteSettingsFile(const std::string& path, const SettingsFile& settings) {
  const Result<std::string> text = FormatSettingsFile(settings);
  return text.ok() ? WriteFileAtomically(path, text->data(), text->size()) : text.status();
}

}  // namespace stillray
