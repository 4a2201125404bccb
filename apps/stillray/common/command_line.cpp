// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "common/command_line.h"

#include <filesystem>
#include <string_view>

namespace stillray {
namespace {

std::string command_line;

std::string Quoted(std::string_view argument) {
  constexpr std::string_view kPlain =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_-+=./:,@%";
  if (!argument.empty() && argument.find_first_not_of(kPlain) == std::string_view::npos) {
    return std::string(argument);
  }
  std::string quoted = "'";
  for (const char c : argument) {
    quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  }
  return quoted + "'";
}

}  // namespace

void KeepCommandLine(int argc, char** argv) {
  command_line = argc > 0 ? Quoted(std::filesystem::path(argv[0]).filename().string()) : "stillray";
  for (int i = 1; i < argc; ++i) {
    command_line += ' ';
    command_line += Quoted(argv[i]);
  }
}

const std::string& CommandLine() {
  return command_line;
}

}  // namespace stillray
