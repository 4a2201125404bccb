// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// What all subcommands share of the command line: its errors, its numbers, and `stillray help`.
#pragma once

#include <string>
#include <vector>

#include <CLI/CLI.hpp>

namespace stillray {

/// `stillray help` and `stillray help COMMAND`, as --help of either.
void AddHelpCommand(CLI::App& app, int* exit_code);

/// Lets every option of a whole or floating-point number refuse what is not one in decimal digits,
/// or does not fit: CLI11 wraps "-1" of an unsigned number, and reads "010" as 8.
void CheckNumbers(CLI::App& app);

/// The arguments in the order that CLI::App::parse expects, last first. A file named "[shot]" gets
/// "./" in front, or CLI11 would take its brackets for those of a list.
std::vector<std::string> ArgumentsOf(CLI::App& app, int argc, const char* const* argv);

/// One line on what is wrong with the command line, with the nearest known command or option.
std::string UsageError(const CLI::App& app, const CLI::Error& error);

}  // namespace stillray
