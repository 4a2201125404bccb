// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "completion/option_tables.h"

#include <algorithm>
#include <string_view>

#include "stillray/denoise.hpp"
#include "stillray/scene.h"

namespace stillray {
namespace {

using Names = std::vector<std::string>;

/// Splits "full|sparse"; empty if the text is not a list of names, such as "N|1/N" for numbers.
Names SplitChoices(const std::string& text) {
  Names names = CLI::detail::split(text, '|');
  const auto is_name = [](const std::string& name) {
    return !name.empty() && std::all_of(name.begin(), name.end(), [](char c) {
      return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
    });
  };
  const bool list = names.size() > 1 && std::all_of(names.begin(), names.end(), is_name);
  return list ? names : Names();
}

/// The names accepted by a OneOf() check.
Names CheckedNames(CLI::Option* option) {
  try {
    for (int i = 0;; ++i) {
      Names names = SplitChoices(option->get_validator(i)->get_name());
      if (!names.empty()) {
        return names;
      }
    }
  } catch (const CLI::OptionNotFound&) {
    return {};  // no more checks
  }
}

Names ParameterChoices(std::string_view name) {
  for (const Parameter& p : Parameters()) {
    if (p.name == name) {
      return Names(p.choices.begin(), p.choices.end());
    }
  }
  return {};
}

/// Prefixes of --set values: "sigma_l=", ...
Names ParameterAssignments() {
  Names names;
  for (const Parameter& p : Parameters()) {
    names.push_back(std::string(p.name) + "=");
  }
  return names;
}

/// Options whose values are checked when they are used, not when they are parsed.
Names ValuesOfOption(const std::string& name) {
  if (name == "preset") {
    return Names(PresetNames().begin(), PresetNames().end());
  }
  if (name == "tonemap") {
    return ParameterChoices(name);
  }
  if (name == "device") {
    return {"auto", "cpu", "vulkan"};
  }
  return name == "set" ? ParameterAssignments() : Names();
}

Names ValuesOf(CLI::Option* option) {
  Names names = SplitChoices(option->get_type_name());
  if (names.empty()) {
    names = CheckedNames(option);
  }
  if (names.empty() && !option->get_lnames().empty()) {
    names = ValuesOfOption(option->get_lnames().front());
  }
  return names;
}

OptionEntry ReadOption(CLI::Option* option) {
  OptionEntry entry;
  for (const std::string& name : option->get_snames()) {
    entry.names.push_back("-" + name);
  }
  for (const std::string& name : option->get_lnames()) {
    entry.names.push_back("--" + name);
  }
  if (option->get_items_expected_max() > 0) {
    entry.value = option->get_type_name();
    entry.value.resize(std::min(entry.value.find(':'), entry.value.size()));  // "INT:INT in [..]"
    entry.values = ValuesOf(option);
    entry.default_value = option->get_default_str();
  }
  entry.help = option->get_description();
  return entry;
}

bool TakesScene(const std::string& help) {
  return help.find("builtin:NAME") != std::string::npos;
}

PositionalEntry ReadPositional(CLI::Option* option) {
  PositionalEntry entry;
  entry.name = option->get_name(true);
  entry.help = option->get_description();
  entry.required = option->get_required();
  entry.repeated = option->get_items_expected_max() > 1;
  entry.values = CheckedNames(option);
  entry.takes_files = entry.values.empty();
  if (TakesScene(entry.help)) {
    for (const std::string& name : BuiltinSceneNames()) {
      entry.values.push_back(name.starts_with("builtin:") ? name : "builtin:" + name);
    }
  }
  return entry;
}

bool IsShown(const CLI::Option* option) {
  return !option->get_group().empty();
}

std::vector<OptionEntry> ReadOptions(CLI::App& command) {
  std::vector<OptionEntry> entries;
  for (CLI::Option* option : command.get_options({})) {
    if (!option->get_positional() && IsShown(option)) {
      entries.push_back(ReadOption(option));
      if (TakesScene(entries.back().help)) {
        entries.back().values = ReadPositional(option).values;
      }
    }
  }
  return entries;
}

CommandEntry ReadCommand(CLI::App& command) {
  CommandEntry entry;
  entry.name = command.get_name();
  entry.help = command.get_description();
  entry.footer = command.get_footer();
  entry.options = ReadOptions(command);
  for (CLI::Option* option : command.get_options({})) {
    if (option->get_positional() && IsShown(option)) {
      entry.positionals.push_back(ReadPositional(option));
    }
  }
  return entry;
}

/// Sets the values of `stillray help`: command names.
void SetCommandNames(ProgramEntry* program) {
  Names names;
  for (const CommandEntry& command : program->commands) {
    names.push_back(command.name);
  }
  for (CommandEntry& command : program->commands) {
    if (command.name == "help" && !command.positionals.empty()) {
      command.positionals.front().values = names;
      command.positionals.front().takes_files = false;
    }
  }
}

}  // namespace

ProgramEntry ReadOptionTables(CLI::App& app) {
  ProgramEntry program;
  program.help = app.get_description();
  program.options = ReadOptions(app);
  for (CLI::App* command : app.get_subcommands([](CLI::App*) { return true; })) {
    if (!command->get_group().empty()) {
      program.commands.push_back(ReadCommand(*command));
    }
  }
  SetCommandNames(&program);
  return program;
}

std::string ShortHelp(const std::string& help) {
  size_t end = help.size();
  for (const char* mark : {". ", "; ", ": ", ", such as "}) {
    end = std::min(end, help.find(mark));
  }
  constexpr size_t kWidth = 76;
  if (end > kWidth) {
    end = help.rfind(' ', kWidth);
  }
  return help.substr(0, end);
}

}  // namespace stillray
