// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The command line as data, read from the declared options: shell completion and manual page are
/// generated from it, and therefore cover all commands and options.
#pragma once

#include <string>
#include <vector>

#include <CLI/CLI.hpp>

namespace stillray {

struct OptionEntry {
  std::vector<std::string> names;   ///< "-o", "--output"; those of flags with "--no-"
  std::string value;                ///< placeholder of its value, such as "TEXT"; "" for a flag
  std::vector<std::string> values;  ///< allowed values; empty: a file, a number, a text
  std::string default_value;        ///< "" if there is none
  std::string help;                 ///< without a full stop
};

struct PositionalEntry {
  std::string name;
  std::vector<std::string> values;  ///< suggested values; other values, such as files, may be valid
  bool takes_files = true;
  bool required = false;
  bool repeated = false;
  std::string help;
};

struct CommandEntry {
  std::string name;
  std::string help;
  std::string footer;  ///< description of the command, and examples
  std::vector<OptionEntry> options;
  std::vector<PositionalEntry> positionals;
};

struct ProgramEntry {
  std::string help;
  std::vector<OptionEntry> options;
  std::vector<CommandEntry> commands;
};

/// All commands and options of the program, except hidden ones.
ProgramEntry ReadOptionTables(CLI::App& app);

/// The first clause of a help text, for one line of a list.
std::string ShortHelp(const std::string& help);

}  // namespace stillray
