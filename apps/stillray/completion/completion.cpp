// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// `stillray completion SHELL` and `stillray man`, whose output is installed by packages.
#include <memory>
#include <string>

#include <CLI/CLI.hpp>

#include "common/commands.h"
#include "common/console.h"
#include "common/option_checks.h"
#include "completion/manual_page.h"
#include "completion/option_tables.h"
#include "completion/shell_scripts.h"

namespace stillray {

void AddCompletionCommands(CLI::App& app) {
  CLI::App* completion =
      app.add_subcommand("completion", "Print the completion of this command line for a shell");
  const auto shell = std::make_shared<std::string>();
  completion->add_option("SHELL", *shell, "bash, zsh or fish")
      ->required()
      ->check(OneOf({"bash", "zsh", "fish"}));
  completion->footer(
      "Examples:\n"
      "  source <(stillray completion bash)\n"
      "  stillray completion zsh > ~/.zfunc/_stillray\n"
      "  stillray completion fish > ~/.config/fish/completions/stillray.fish");
  completion->callback([&app, shell] {
    const ProgramEntry program = ReadOptionTables(app);
    WriteText(stdout, *shell == "bash"  ? BashCompletion(program)
                      : *shell == "zsh" ? ZshCompletion(program)
                                        : FishCompletion(program));
  });

  CLI::App* man = app.add_subcommand("man", "Print the manual page, in roff");
  man->footer("Examples:\n  stillray man | man -l -");
  man->callback([&app] { WriteText(stdout, ManualPage(ReadOptionTables(app), STILLRAY_VERSION)); });
}

}  // namespace stillray
