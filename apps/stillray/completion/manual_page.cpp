// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "completion/manual_page.h"

#include <algorithm>
#include <sstream>
#include <string_view>

#include <fmt/format.h>

namespace stillray {
namespace {

/// Escapes text for roff, where "-" would become a hyphen, and "\", as well as "." and "'" at the
/// beginning of a line, start a request.
std::string Text(std::string_view text) {
  std::string roff;
  for (const char c : text) {
    if (c == '\\') {
      roff += "\\e";
    } else if (c == '-') {
      roff += "\\-";
    } else if ((c == '.' || c == '\'') && (roff.empty() || roff.back() == '\n')) {
      roff += std::string("\\&") + c;
    } else {
      roff += c;
    }
  }
  return roff;
}

std::string Sentence(const std::string& help) {
  return Text(help) + (help.empty() || help.back() == '.' ? "\n" : ".\n");
}

std::string Heading(const OptionEntry& option) {
  std::string text;
  for (const std::string& name : option.names) {
    text += fmt::format("{}\\fB{}\\fR", text.empty() ? "" : ", ", Text(name));
  }
  if (!option.value.empty()) {
    text += fmt::format(" \\fI{}\\fR", Text(option.value));
  }
  return text + "\n";
}

std::string Option(const OptionEntry& option) {
  std::string text = ".TP\n" + Heading(option) + Sentence(option.help);
  if (!option.values.empty() && !option.values.front().ends_with("=")) {
    std::string names;
    for (const std::string& name : option.values) {
      names += (names.empty() ? "" : ", ") + name;
    }
    text += "Values: " + Text(names) + ".\n";
  }
  if (!option.default_value.empty()) {
    text += "Default: " + Text(option.default_value) + ".\n";
  }
  return text;
}

std::string Synopsis(const CommandEntry& command) {
  std::string text = fmt::format("\\fBstillray {}\\fR [\\fIoptions\\fR]", Text(command.name));
  for (const PositionalEntry& p : command.positionals) {
    const std::string name = fmt::format("\\fI{}\\fR{}", Text(p.name), p.repeated ? " ..." : "");
    text += p.required ? " " + name : " [" + name + "]";
  }
  return text + "\n";
}

/// Footers are formatted for terminals: line breaks are preserved.
std::string Footer(const std::string& footer) {
  const size_t first = footer.find_first_not_of('\n');
  if (first == std::string::npos) {
    return {};
  }
  std::string lines;
  std::istringstream stream(footer.substr(first));
  for (std::string line; std::getline(stream, line);) {
    lines += line.empty() ? ".sp\n" : Text(line) + "\n";
  }
  return ".PP\n.nf\n" + lines + ".fi\n";
}

std::string Command(const CommandEntry& command) {
  std::string text = fmt::format(".SS stillray {}\n{}.PP\n{}", Text(command.name),
                                 Sentence(command.help), Synopsis(command));
  for (const PositionalEntry& p : command.positionals) {
    text += fmt::format(".TP\n\\fI{}\\fR\n{}", Text(p.name), Sentence(p.help));
  }
  for (const OptionEntry& option : command.options) {
    text += Option(option);
  }
  return text + Footer(command.footer);
}

constexpr std::string_view kTail = R"(.SH EXIT STATUS
.TP
0
Success.
.TP
1
A defect of stillray.
.TP
2
An error of the command line, of a file or of the machine; one line on standard error names it.
.TP
3
\fBstillray check\fR has findings.
.TP
130
Stopped by the user.
.SH ENVIRONMENT
.TP
\fBVK_DRIVER_FILES\fR
Of the Vulkan loader: the drivers to use; a file that does not exist hides all of them.
.SH SEE ALSO
\fBffmpeg\fR(1), which writes videos; the documents in
.IR /usr/share/doc/stillray .
)";

}  // namespace

std::string ManualPage(const ProgramEntry& program, const std::string& version) {
  std::string help = program.help;
  if (const size_t colon = help.find(": "); colon != std::string::npos) {
    help = help.substr(colon + 2);
  }
  std::string text = fmt::format(
      ".TH STILLRAY 1 \"\" \"stillray {}\" \"User Commands\"\n.SH NAME\nstillray \\- {}\n",
      Text(version), Text(help));
  text += ".SH SYNOPSIS\n";
  for (const CommandEntry& command : program.commands) {
    text += (text.ends_with("SYNOPSIS\n") ? "" : ".br\n") + Synopsis(command);
  }
  text +=
      ".SH DESCRIPTION\nA path tracer and a spatiotemporal denoiser for path\\-traced animation: "
      "it renders scenes,\ndenoises sequences of EXR files of any renderer, and measures the "
      "result.\n.SH OPTIONS\n";
  for (const OptionEntry& option : program.options) {
    text += Option(option);
  }
  text += ".SH COMMANDS\n";
  for (const CommandEntry& command : program.commands) {
    text += Command(command);
  }
  return text + std::string(kTail);
}

}  // namespace stillray
