// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <csignal>
#include <cstdio>
#include <string>
#include <system_error>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "common/command_line.h"
#include "common/commands.h"
#include "common/console.h"
#include "common/trace_device.h"
#include "common/usage.h"

namespace stillray {

int ReportError(const Status& status) {
  PrintTo(stderr, "stillray: error: {}\n", status.message());
  switch (status.code()) {
    case StatusCode::kOk:
      return kExitOk;
    case StatusCode::kInternal:
      return kExitInternal;
    case StatusCode::kCancelled:
      return kExitCancelled;
    default:
      return kExitBadInput;
  }
}

namespace {

/// Failure to create a thread is a system error; all other system_errors are defects of stillray.
Status OfSystem(const std::system_error& error) {
  if (error.code() == std::errc::resource_unavailable_try_again) {
    return Status::OutOfMemory(fmt::format(
        "no thread could be started ({}): the limit on threads (ulimit -u) or memory is reached; "
        "--threads 1 needs the fewest",
        error.what()));
  }
  return Status::Internal(fmt::format("unexpected: {}", error.what()));
}

int Main(int argc, char** argv) {
  CLI::App app{"stillray: clean, temporally stable pictures from a few samples per pixel",
               "stillray"};
  app.set_version_flag("--version", std::string("stillray " STILLRAY_VERSION));
  app.require_subcommand(0, 1);
  // The last occurrence of an option takes effect, so that scripts can append to a command line.
  app.option_defaults()->multi_option_policy(CLI::MultiOptionPolicy::TakeLast);
  app.footer(
      "stillray help COMMAND explains a command, with examples. Exit codes: 0 success, 2 bad "
      "input, 1 a defect of stillray, 3 findings of check, 130 interrupted.");
  int exit_code = kExitOk;
  AddRenderCommand(app, &exit_code);
  AddDenoiseCommand(app, &exit_code);
  AddViewCommand(app, &exit_code);
  AddCompareCommand(app, &exit_code);
  AddReportCommand(app, &exit_code);
  AddInfoCommand(app, &exit_code);
  AddCheckCommand(app, &exit_code);
  AddBenchCommand(app, &exit_code);
  AddShadersCommand(app, &exit_code);
  AddHelpCommand(app, &exit_code);
  AddCompletionCommands(app);
  CheckNumbers(app);
  try {
    app.parse(ArgumentsOf(app, argc, argv));
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == static_cast<int>(CLI::ExitCodes::Success)) {
      return app.exit(error);  // --help, --version
    }
    return ReportError(Status::InvalidArgument(UsageError(app, error)));
  }
  if (app.get_subcommands().empty()) {
    WriteText(stdout, ShortHelp());
  }
  return exit_code;
}

/// Lost standard output is an error, even after success or findings.
int WithOutputWritten(int exit_code) {
  const int error = OutputError();
  if (error == 0 || (exit_code != kExitOk && exit_code != kExitFindings)) {
    return exit_code;
  }
  return ReportError(Status::Io("standard output: could not be written: " +
                                std::generic_category().message(error)));
}

}  // namespace
}  // namespace stillray

int main(int argc, char** argv) {
  // A write beyond the file size limit then fails with a message instead of terminating the
  // program.
  std::signal(SIGXFSZ, SIG_IGN);
  stillray::OccupyClosedStreams();
  stillray::KeepCommandLine(argc, argv);
  stillray::KeepCompiledShaders();
  try {
    return stillray::WithOutputWritten(stillray::Main(argc, argv));
  } catch (const std::bad_alloc&) {
    return stillray::ReportError(stillray::Status::OutOfMemory("out of memory"));
  } catch (const std::system_error& error) {
    return stillray::ReportError(stillray::OfSystem(error));
  } catch (const std::exception& error) {
    return stillray::ReportError(
        stillray::Status::Internal(std::string("unexpected: ") + error.what()));
  }
}
