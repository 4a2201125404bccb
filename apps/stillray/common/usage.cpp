// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "common/usage.h"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <string_view>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "common/commands.h"
#include "common/console.h"
#include "core/nearest_names.h"

namespace stillray {
namespace {

std::vector<const CLI::App*> Commands(const CLI::App& app) {
  return app.get_subcommands([](const CLI::App*) { return true; });
}

std::vector<std::string> CommandNames(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* command : Commands(app)) {
    names.push_back(command->get_name());
  }
  return names;
}

std::string UnknownCommand(const CLI::App& app, const std::string& name) {
  const std::vector<std::string> names = CommandNames(app);
  const std::string meant = DidYouMeanOneOf(name, names);
  return fmt::format(
      "unknown command '{}'{}", name,
      meant.empty() ? fmt::format("; commands are: {}", fmt::join(names, ", ")) : meant);
}

std::string UnknownOption(const CLI::App& command, const std::string& usage,
                          const std::string& argument) {
  const std::string name = argument.substr(0, argument.find('='));
  std::vector<std::string> names;
  for (const CLI::Option* option : command.get_options()) {
    for (const std::string& known : option->get_lnames()) {
      names.push_back("--" + known);
    }
  }
  const std::string meant = DidYouMeanOneOf(name, names);
  return fmt::format("unknown option '{}'{}", name,
                     meant.empty() ? fmt::format("; {} --help lists all of them", usage) : meant);
}

/// Validates a decimal number without leading zeros, which CLI11 would parse as octal.
template <typename T>
std::string CheckNumber(std::string* text, const std::string& expected) {
  std::string_view digits = *text;
  if (!digits.empty() && digits.front() == '+') {
    digits.remove_prefix(1);
  }
  T number = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
  const bool whole = error == std::errc() && end == digits.data() + digits.size();
  if (!whole || number != number) {
    return fmt::format("found '{}', expected {}", *text, expected);
  }
  if constexpr (std::numeric_limits<T>::is_integer) {
    *text = fmt::format("{}", number);
  }
  return {};
}

template <typename T>
std::string WholeNumber() {
  return fmt::format("a whole number from {} to {}", std::numeric_limits<T>::min(),
                     std::numeric_limits<T>::max());
}

/// Adds a check by CLI11's type name: all signed integer options have 32 bits.
void CheckOption(CLI::Option* option) {
  const std::string type = option->get_type_name();
  std::function<std::string(std::string&)> check;
  if (type.starts_with("UINT")) {
    check = [](std::string& text) { return CheckNumber<uint64_t>(&text, WholeNumber<uint64_t>()); };
  } else if (type.starts_with("INT")) {
    check = [](std::string& text) { return CheckNumber<int32_t>(&text, WholeNumber<int32_t>()); };
  } else if (type.starts_with("FLOAT")) {
    check = [](std::string& text) { return CheckNumber<double>(&text, "a number"); };
  }
  if (check) {
    option->transform(CLI::Validator(check, ""));  // before other checks, which parse the number
  }
}

}  // namespace

std::string ShortHelp() {
  return R"(stillray: clean, temporally stable pictures from a few samples per pixel

Begin with:
  stillray render                             a built-in scene: clean frames and a video in out/
  stillray render scene.glb -o clean          a scene (glTF or OBJ)
  stillray denoise 'in.####.exr' -o clean     noisy frames of Blender, Arnold or another renderer
  stillray view scene.glb                     a scene live, in a window

stillray help              all commands: compare, report, check, info, bench, shaders
stillray help COMMAND      options and examples
)";
}

void AddHelpCommand(CLI::App& app, int* exit_code) {
  CLI::App* command = app.add_subcommand("help", "Explain a command, as COMMAND --help does");
  const auto name = std::make_shared<std::string>();
  command->add_option("command", *name, "Name of the command; none: an overview");
  command->callback([&app, name, exit_code] {
    if (name->empty()) {
      // App::help would return the help of `help`, the current command.
      WriteText(stdout,
                app.get_formatter()->make_help(&app, app.get_name(), CLI::AppFormatMode::Normal));
      return;
    }
    const std::vector<std::string> names = CommandNames(app);
    if (std::find(names.begin(), names.end(), *name) == names.end()) {
      *exit_code = ReportError(Status::InvalidArgument(UnknownCommand(app, *name)));
      return;
    }
    WriteText(stdout, app.get_subcommand(*name)->help("stillray"));
  });
}

void CheckNumbers(CLI::App& app) {
  for (CLI::App* command : app.get_subcommands([](CLI::App*) { return true; })) {
    for (CLI::Option* option : command->get_options({})) {
      CheckOption(option);
    }
  }
}

std::vector<std::string> ArgumentsOf(CLI::App& app, int argc, const char* const* argv) {
  std::vector<std::string> arguments;
  const auto named = [&](CLI::App* command) { return argc > 1 && command->get_name() == argv[1]; };
  const std::vector<CLI::App*> commands = app.get_subcommands(named);
  CLI::App* command = commands.empty() ? nullptr : commands.front();
  for (int i = 1; i < argc; ++i) {
    std::string text = argv[i];
    // CLI11 also leaves values of such options unchanged.
    const CLI::Option* option =
        command != nullptr && i > 1 ? command->get_option_no_throw(argv[i - 1]) : nullptr;
    const bool single = option != nullptr && option->get_items_expected_max() > 0 &&
                        !option->get_allow_extra_args();
    if (!single && text.size() > 1 && text.front() == '[' && text.back() == ']') {
      text.insert(0, "./");
    }
    arguments.push_back(std::move(text));
  }
  std::reverse(arguments.begin(), arguments.end());
  return arguments;
}

std::string UsageError(const CLI::App& app, const CLI::Error& error) {
  const std::vector<CLI::App*> used = app.get_subcommands();
  const CLI::App& command = used.empty() ? app : *used.front();
  const std::string usage = used.empty() ? "stillray" : "stillray " + command.get_name();
  const std::vector<std::string> rest = app.remaining(true);
  const auto is_option = [](const std::string& text) { return text.size() > 1 && text[0] == '-'; };
  const auto option = std::find_if(rest.begin(), rest.end(), is_option);
  if (option != rest.end()) {
    return UnknownOption(command, usage, *option);
  }
  if (used.empty() && !rest.empty()) {
    return UnknownCommand(app, rest.front());
  }
  return fmt::format("{} (see {} --help)", error.what(), usage);
}

}  // namespace stillray
