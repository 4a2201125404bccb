// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "common/settings_file.h"

#include <charconv>

#include <fmt/format.h>

#include "stillray/io.h"
#include "view/sample_rate.h"

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

Status OneOf(std::string_view name, std::string_view value, std::string_view a, std::string_view b,
             std::optional<std::string>* out) {
  if (value != a && value != b) {
    return Status::BadData(fmt::format("{} is '{}', expected {} or {}", name, value, a, b));
  }
  *out = std::string(value);
  return Status::Ok();
}

Status SetBounces(std::string_view value, RenderLines* render) {
  int bounces = 0;
  const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), bounces);
  if (error != std::errc() || end != value.data() + value.size() || bounces < 1 || bounces > 32) {
    return Status::BadData(fmt::format("render.bounces is '{}', expected 1 to 32", value));
  }
  render->bounces = bounces;
  return Status::Ok();
}

Status SetRenderLine(std::string_view name, std::string_view value, RenderLines* render) {
  if (name == "render.spp") {
    const Result<view::SampleRate> rate = view::ParseSampleRate(value);
    if (rate.ok()) {
      render->spp = view::ToText(rate.value());
    }
    return rate.status();
  }
  if (name == "render.guides") {
    return OneOf(name, value, "full", "sparse", &render->guides);
  }
  if (name == "render.bounces") {
    return SetBounces(value, render);
  }
  if (name == "render.sampler") {
    return OneOf(name, value, "sobol", "halton16", &render->sampler);
  }
  if (name == "render.regularise") {
    std::optional<std::string> flag;
    STILLRAY_RETURN_IF_ERROR(OneOf(name, value, "on", "off", &flag));
    render->regularise = *flag == "on";
    return Status::Ok();
  }
  return Status::BadData(
      fmt::format("unknown setting '{}', expected render.spp, render.guides, render.bounces, "
                  "render.sampler or render.regularise",
                  name));
}

Status SetLine(std::string_view line, bool first, SettingsFile* file) {
  const size_t equals = line.find('=');
  if (equals == std::string_view::npos) {
    return Status::BadData(fmt::format("'{}' has no '=', expected name=value", line.substr(0, 80)));
  }
  const std::string_view name = Trim(line.substr(0, equals));
  const std::string_view value = Trim(line.substr(equals + 1));
  if (name == "preset") {
    if (!first) {
      return Status::BadData("preset stands below other settings, expected it above all");
    }
    Result<Settings> preset = PresetSettings(value);
    if (preset.ok()) {
      file->preset = std::string(value);
      file->denoise = preset.value();
    }
    return preset.status();
  }
  if (name.substr(0, kRenderPrefix.size()) == kRenderPrefix) {
    return SetRenderLine(name, value, &file->render);
  }
  return SetParameter(&file->denoise, name, value);
}

void AppendRenderLines(const RenderLines& render, std::string* text) {
  const auto line = [&](const char* name, const auto& value) {
    if (value) {
      *text += fmt::format("render.{}={}\n", name, *value);
    }
  };
  line("spp", render.spp);
  line("guides", render.guides);
  line("bounces", render.bounces);
  line("sampler", render.sampler);
  if (render.regularise) {
    *text += fmt::format("render.regularise={}\n", *render.regularise ? "on" : "off");
  }
}

/// "name=value" of every parameter that differs from the preset.
Result<std::vector<std::string>> ChangesOf(const SettingsFile& settings) {
  const Result<Settings> preset = PresetSettings(settings.preset);
  if (!preset.ok()) {
    return preset.status();
  }
  STILLRAY_RETURN_IF_ERROR(ValidateSettings(settings.denoise));
  std::vector<std::string> changes;
  for (const Parameter& p : Parameters()) {
    const std::string value = GetParameter(settings.denoise, p.name).value();
    if (value != GetParameter(preset.value(), p.name).value()) {
      changes.push_back(fmt::format("{}={}", p.name, value));
    }
  }
  return changes;
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

Status SettingsFileAsOptions(const std::string& path, std::string* preset,
                             std::vector<std::string>* set, RenderLines* render) {
  const Result<SettingsFile> file = ReadSettingsFile(path);
  if (!file.ok()) {
    return Status(file.status().code(), "--settings: " + file.status().message());
  }
  const Result<std::vector<std::string>> changes = ChangesOf(file.value());
  if (!changes.ok()) {
    return changes.status();
  }
  *preset = file->preset;
  set->insert(set->begin(), changes->begin(), changes->end());
  *render = file->render;
  return Status::Ok();
}

Result<std::string> FormatSettingsFile(const SettingsFile& settings) {
  const Result<std::vector<std::string>> changes = ChangesOf(settings);
  if (!changes.ok()) {
    return changes.status();
  }
  std::string text = fmt::format("# stillray settings\npreset={}\n", settings.preset);
  for (const std::string& line : changes.value()) {
    text += line + "\n";
  }
  AppendRenderLines(settings.render, &text);
  return text;
}

Status WriteSettingsFile(const std::string& path, const SettingsFile& settings) {
  const Result<std::string> text = FormatSettingsFile(settings);
  return text.ok() ? WriteFileAtomically(path, text->data(), text->size()) : text.status();
}

}  // namespace stillray
