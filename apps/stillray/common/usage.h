// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The common part of the command line of all subcommands: errors, numbers, and `stillray help`.
#pragma once

#include <string>
#include <vector>

#include <CLI/CLI.hpp>

namespace stillray {

/// The output of `stillray` without arguments: the most important commands, and how to list all
/// others.
std::string ShortHelp();

/// Adds `stillray help` and `stillray help COMMAND`, equivalent to --help.
void AddHelpCommand(CLI::App& app, int* exit_code);

/// Makes all numeric options reject values that are out of range or not decimal numbers: CLI11
/// wraps "-1" of an unsigned number, and reads "010" as 8.
void CheckNumbers(CLI::App& app);

/// The arguments in the order of CLI::App::parse, last first. A file named "[shot]" gets the prefix
/// "./", since CLI11 would parse it as a list.
std::vector<std::string> ArgumentsOf(CLI::App& app, int argc, const char* const* argv);

/// A one-line message for a command line error, which suggests the closest command or option.
std::string UsageError(const CLI::App& app, const CLI::Error& error);

}  // namespace stillray
