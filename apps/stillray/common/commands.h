// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The subcommands of the program, one file each.
#pragma once

#include "stillray/status.h"

namespace CLI {
class App;
}

namespace stillray {

/// Exit codes of the program, which are part of its interface.
inline constexpr int kExitOk = 0;
inline constexpr int kExitInternal = 1;     ///< a defect of stillray
inline constexpr int kExitBadInput = 2;     ///< an error of the command line, a file or the system
inline constexpr int kExitFindings = 3;     ///< stillray check has findings
inline constexpr int kExitCancelled = 130;  ///< stopped by the user (Ctrl-C)

/// Prints "stillray: error: ..." to stderr and returns the exit code of the status.
int ReportError(const Status& status);

/// Each function adds its subcommand to `app`; the callback of the subcommand runs it and stores
/// the exit code.
void AddRenderCommand(CLI::App& app, int* exit_code);
void AddDenoiseCommand(CLI::App& app, int* exit_code);
void AddViewCommand(CLI::App& app, int* exit_code);
void AddCompareCommand(CLI::App& app, int* exit_code);
void AddReportCommand(CLI::App& app, int* exit_code);
void AddInfoCommand(CLI::App& app, int* exit_code);
void AddCheckCommand(CLI::App& app, int* exit_code);
void AddBenchCommand(CLI::App& app, int* exit_code);
void AddShadersCommand(CLI::App& app, int* exit_code);
/// Adds `completion` and `man`, which are generated from the options of all commands.
void AddCompletionCommands(CLI::App& app);

}  // namespace stillray
