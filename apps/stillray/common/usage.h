// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The common part of the command line of all subcommands: errors, numbers, and `stillray help`.
#pragma once

#include <string>
#include <vector>

#include <CLI/CLI.hpp>

namespace stillray {

/// The output of `stillray` without arguments: the most important commands, and how to list the
/// others.
std::string ShortHelp();

/// `stillray help` and `stillray help COMMAND`, like --help.
void AddHelpCommand(CLI::App& app, int* exit_code);

/// Makes every numeric option reject values that are not decimal numbers, or out of range: CLI11
/// wraps "-1" of an unsigned number, and reads "010" as 8.
void CheckNumbers(CLI::App& app);

/// The arguments in the order that CLI::App::parse expects, last first. A file named "[shot]" gets
/// the prefix "./", or CLI11 would parse it as a list.
std::vector<std::string> ArgumentsOf(CLI::App& app, int argc, const char* const* argv);

/// One line on the error of the command line, with the nearest known command or option.
std::string UsageError(const CLI::App& app, const CLI::Error& error);

}  // namespace stillray
