// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <csignal>
#include <cstdio>
#include <string>
#include <system_error>

#include <CLI/CLI.hpp>

#include "command_line.h"
#include "commands.h"
#include "console.h"

namespace stillray {

int ReportError(const Status& status) {
  std::fprintf(stderr, "stillray: error: %s\n", status.message().c_str());
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

int Main(int argc, char** argv) {
  CLI::App app{"stillray: clean, temporally stable pictures from a few samples per pixel"};
  app.set_version_flag("--version", std::string("stillray " STILLRAY_VERSION));
  app.require_subcommand(1);
  // The last of a repeated option counts, so that scripts can append to a command line.
  app.option_defaults()->multi_option_policy(CLI::MultiOptionPolicy::TakeLast);
  app.failure_message([](const CLI::App*, const CLI::Error& error) {
    return std::string("stillray: error: ") + error.what() + " (--help tells the usage)\n";
  });
  int exit_code = kExitOk;
  AddRenderCommand(app, &exit_code);
  AddDenoiseCommand(app, &exit_code);
  AddViewCommand(app, &exit_code);
  AddCompareCommand(app, &exit_code);
  AddReportCommand(app, &exit_code);
  AddInfoCommand(app, &exit_code);
  AddCheckCommand(app, &exit_code);
  AddBenchCommand(app, &exit_code);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kExitOk : kExitBadInput;
  }
  return exit_code;
}

/// Findings of a check that went nowhere are no result either.
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
  // A write past a limit on file sizes then fails with a message instead of ending the program.
  std::signal(SIGXFSZ, SIG_IGN);
  stillray::OccupyClosedStreams();
  stillray::KeepCommandLine(argc, argv);
  try {
    return stillray::WithOutputWritten(stillray::Main(argc, argv));
  } catch (const std::bad_alloc&) {
    return stillray::ReportError(stillray::Status::OutOfMemory("out of memory"));
  } catch (const std::exception& error) {
    return stillray::ReportError(
        stillray::Status::Internal(std::string("unexpected: ") + error.what()));
  }
}
