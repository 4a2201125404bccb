// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "common/tracer_options.h"

#include <algorithm>
#include <string>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

namespace stillray {
namespace {

/// Help text of an option, without full stop.
std::string HelpOf(const Parameter& p) {
  std::string help = p.help;
  help.pop_back();
  return help;
}

/// The placeholder of the value in --help.
std::string ValuesOf(const Parameter& p) {
  switch (p.type) {
    case ParameterType::kChoice:
    case ParameterType::kText:
      return fmt::format("{}", fmt::join(p.choices, "|"));
    case ParameterType::kRate:
      return "N|1/N";
    default:
      return "N";
  }
}

/// The option name of a setting, with dashes like all options.
std::string OptionName(std::string name) {
  std::replace(name.begin(), name.end(), '_', '-');
  return name;
}

void AddFlag(const Parameter& p, CLI::App* command, RenderLines* given) {
  const auto take = [given, &p](int64_t on) { given->push_back({p.name, on > 0 ? "on" : "off"}); };
  command->add_flag_function(fmt::format("--{0},!--no-{0}", OptionName(p.name)), take, HelpOf(p))
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeLast);
}

void AddValue(const Parameter& p, const std::string& by_default, CLI::App* command,
              RenderLines* given) {
  const auto take = [given, &p](const std::string& value) { given->push_back({p.name, value}); };
  command
      ->add_option_function<std::string>(fmt::format("--{}", OptionName(p.name)), take, HelpOf(p))
      ->type_name(ValuesOf(p))
      ->default_str(by_default);
}

}  // namespace

void AddTracerOptions(CLI::App* command, TracerArguments* arguments) {
  for (const Parameter& p : RenderParameters()) {
    if (p.type == ParameterType::kFlag) {
      AddFlag(p, command, &arguments->given);
    } else {
      AddValue(p, GetRenderParameter(arguments->defaults, p.name).value(), command,
               &arguments->given);
    }
  }
}

Result<RenderSettings> ParseTracerArguments(const TracerArguments& arguments,
                                            const RenderLines& file) {
  RenderSettings settings = arguments.defaults;
  STILLRAY_RETURN_IF_ERROR(ApplyRenderLines(file, &settings));
  for (const RenderLine& line : arguments.given) {
    const Status set = SetRenderParameter(&settings, line.name, line.value);
    if (!set.ok()) {
      // The message starts with the setting's name.
      return Status::InvalidArgument("--" + OptionName(line.name) +
                                     set.message().substr(line.name.size()));
    }
  }
  return settings;
}

}  // namespace stillray
