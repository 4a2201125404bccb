// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "common/filter_options.h"

#include <fmt/format.h>
#include <CLI/CLI.hpp>

namespace stillray {
namespace {

Status ApplyFile(const std::string& path, FilterOptions* options) {
  Result<SettingsFile> file = ReadSettingsFile(path);
  if (!file.ok()) {
    return Status(file.status().code(), "--settings: " + file.status().message());
  }
  const Result<std::vector<std::string>> changed = ChangedParameters(*file);
  STILLRAY_RETURN_IF_ERROR(changed.status());
  options->preset = file->preset;
  options->settings = file->denoise;
  options->set_names = *changed;
  options->render = std::move(file->render);
  return Status::Ok();
}

Status ApplyPreset(const std::string& name, FilterOptions* options) {
  const Result<Settings> preset = PresetSettings(name);
  if (!preset.ok()) {
    return Status::InvalidArgument("--preset: " + preset.status().message());
  }
  options->preset = name;
  options->settings = *preset;
  options->set_names.clear();
  return Status::Ok();
}

}  // namespace

void AddFilterOptions(CLI::App* command, FilterArguments* arguments) {
  command
      ->add_option("--preset", arguments->preset,
                   fmt::format("Settings of the denoiser: {}", fmt::join(PresetNames(), ", ")))
      ->default_str("default");
  command->add_option("--settings", arguments->settings_file,
                      "A file of name=value lines, as the viewer saves them (docs/viewer.md)");
  command
      ->add_option("--set", arguments->set,
                   "A parameter of the denoiser as name=value (docs/parameters.md); repeatable")
      ->allow_extra_args(false)
      ->take_all();
}

Result<FilterOptions> ParseFilterArguments(const FilterArguments& arguments) {
  FilterOptions options;
  if (!arguments.settings_file.empty()) {
    STILLRAY_RETURN_IF_ERROR(ApplyFile(arguments.settings_file, &options));
  }
  if (arguments.preset) {
    STILLRAY_RETURN_IF_ERROR(ApplyPreset(*arguments.preset, &options));
  }
  for (const std::string& assignment : arguments.set) {
    const Status set = AssignParameter(&options.settings, assignment);
    if (!set.ok()) {
      return Status::InvalidArgument("--set: " + set.message());
    }
    options.set_names.push_back(assignment.substr(0, assignment.find('=')));
  }
  STILLRAY_RETURN_IF_ERROR(ValidateSettings(options.settings));
  return options;
}

}  // namespace stillray
