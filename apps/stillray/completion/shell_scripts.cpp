// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "completion/shell_scripts.h"

#include <algorithm>
#include <string_view>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace stillray {
namespace {

/// Escapes text for single quotes in a shell.
std::string Quoted(std::string_view text) {
  std::string quoted = "'";
  for (const char c : text) {
    quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  }
  return quoted + "'";
}

std::vector<std::string> NamesOf(const std::vector<OptionEntry>& options) {
  std::vector<std::string> names;
  for (const OptionEntry& option : options) {
    names.insert(names.end(), option.names.begin(), option.names.end());
  }
  return names;
}

std::vector<std::string> NamesOf(const std::vector<CommandEntry>& commands) {
  std::vector<std::string> names;
  for (const CommandEntry& command : commands) {
    names.push_back(command.name);
  }
  return names;
}

// ---- bash ------------------------------------------------------------------------------------

/// Beginning and end of the script. The script splits the line into words itself: bash breaks words
/// at ':' and '=', which occur in values such as builtin:cornell and sigma_l=2.
constexpr std::string_view kBashHead =
    R"(# bash completion of stillray, written by `stillray completion bash`.
# _stillray_words [values...]: those that begin with the current word. An answer stands for what is
# behind the last break of the shell.
_stillray_words() {
  local value prefix="" breaks="${COMP_WORDBREAKS//[^:=]/}"
  [ -n "$breaks" ] && prefix="${word%"${word##*[$breaks]}"}"
  for value in "$@"; do
    [[ "$value" == "$word"* ]] && COMPREPLY+=("$lead${value#"$prefix"}")
  done
  # The shell adds no space behind sigma_l=.
  [[ ${#COMPREPLY[@]} -gt 0 && "${COMPREPLY[0]}" == *= ]] && compopt -o nospace 2>/dev/null
  return 0
}
_stillray_files() {
  local file
  compopt -o filenames 2>/dev/null
  while IFS= read -r file; do COMPREPLY+=("$file"); done < <(compgen -f -- "$word")
}
_stillray() {
  local line="${COMP_LINE:0:COMP_POINT}" word previous="" command="" options="" lead="" before
  word="${line##*[[:space:]]}"
  before="${line%"$word"}"
  read -r _ command _ <<<"$before"
  before="${before%"${before##*[![:space:]]}"}"
  previous="${before##*[[:space:]]}"
  COMPREPLY=()
  case "$word" in
    --*=*)
      [[ "$COMP_WORDBREAKS" == *=* ]] || lead="${word%%=*}="
      previous="${word%%=*}" word="${word#*=}"
      ;;
  esac
  case "$command:$previous" in
)";

constexpr std::string_view kBashTail = R"(    *) options="" ;;
  esac
  case "$word" in -*) _stillray_words $options ;; esac
  return 0
}
complete -o bashdefault -o default -F _stillray stillray
)";

/// `case` patterns of the option's names behind a command.
std::string BashPattern(const std::string& command, const OptionEntry& option) {
  std::vector<std::string> patterns;
  for (const std::string& name : option.names) {
    patterns.push_back(command + ":" + name);
  }
  return fmt::format("{}", fmt::join(patterns, "|"));
}

std::string BashValues(const CommandEntry& command) {
  std::string text;
  for (const OptionEntry& option : command.options) {
    if (option.value.empty()) {
      continue;
    }
    const std::string pattern = BashPattern(command.name, option);
    if (option.values.empty()) {
      text += fmt::format("    {}) _stillray_files; return 0 ;;\n", pattern);
    } else {
      text += fmt::format("    {}) _stillray_words {}; return 0 ;;\n", pattern,
                          fmt::join(option.values, " "));
    }
  }
  return text;
}

/// The `case` branch that completes the options and the positional arguments of a command.
std::string BashCommand(const CommandEntry& command) {
  std::string words;
  bool files = false;
  for (const PositionalEntry& positional : command.positionals) {
    words += fmt::format("{}{}", words.empty() ? "" : " ", fmt::join(positional.values, " "));
    files = files || positional.takes_files;
  }
  std::string text = fmt::format("    {}:*)\n      options=\"{}\"\n", command.name,
                                 fmt::join(NamesOf(command.options), " "));
  if (!words.empty() || files) {
    text += fmt::format("      case \"$word\" in -*) ;; *) {}{}{} ;; esac\n",
                        words.empty() ? "" : "_stillray_words " + words,
                        !words.empty() && files ? "; " : "", files ? "_stillray_files" : "");
  }
  return text + "      ;;\n";
}

// ---- zsh -------------------------------------------------------------------------------------

/// Escapes text for [...] in _arguments.
std::string ZshText(const std::string& help) {
  std::string text;
  for (const char c : ShortHelp(help)) {
    if (c == '[' || c == ']' || c == ':' || c == '\\') {
      text += '\\';
    }
    text += c;
  }
  return text;
}

/// The action behind the message: names, or files.
std::string ZshAction(const std::vector<std::string>& values, bool files) {
  if (values.empty()) {
    return files ? "_files" : "";
  }
  std::string list = fmt::format("{}", fmt::join(values, " "));
  for (size_t at = 0; (at = list.find(':', at)) != std::string::npos; at += 2) {
    list.insert(at, "\\");
  }
  return files ? fmt::format("_stillray_values_or_files {}", list) : fmt::format("({})", list);
}

std::string ZshOption(const OptionEntry& option) {
  std::string text;
  const std::string exclusive =
      option.names.size() > 1 ? fmt::format("({})", fmt::join(option.names, " ")) : "";
  const bool repeatable = !option.values.empty() && option.values.front().ends_with("=");
  for (const std::string& name : option.names) {
    const bool long_value = !option.value.empty() && name.starts_with("--");
    std::string spec = (repeatable ? std::string("*") : exclusive) + name +
                       (long_value ? "=" : "") + "[" + ZshText(option.help) + "]";
    if (!option.value.empty()) {
      spec += ":value:" + ZshAction(option.values, option.values.empty());
    }
    text += fmt::format("        {} \\\n", Quoted(spec));
  }
  return text;
}

std::string ZshCommand(const CommandEntry& command) {
  std::string text = fmt::format("      {})\n        _arguments -s \\\n", command.name);
  for (const OptionEntry& option : command.options) {
    text += ZshOption(option);
  }
  for (const PositionalEntry& p : command.positionals) {
    text +=
        fmt::format("        {} \\\n", Quoted(fmt::format("{}:{}:{}", p.repeated ? "*" : "", p.name,
                                                          ZshAction(p.values, p.takes_files))));
  }
  text.resize(text.size() - 3);  // " \" of the last line
  return text + "\n        ;;\n";
}

// ---- fish ------------------------------------------------------------------------------------

std::string FishOption(const std::string& condition, const OptionEntry& option) {
  std::string text = fmt::format("complete -c stillray -n {}", Quoted(condition));
  for (const std::string& name : option.names) {
    text += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
  }
  if (!option.values.empty()) {
    text += fmt::format(" -x -a {}", Quoted(fmt::format("{}", fmt::join(option.values, " "))));
  } else if (!option.value.empty()) {
    text += " -r -F";
  }
  return text + fmt::format(" -d {}\n", Quoted(ShortHelp(option.help)));
}

std::string FishCommand(const CommandEntry& command) {
  std::string text = fmt::format("complete -c stillray -n __fish_use_subcommand -f -a {} -d {}\n",
                                 command.name, Quoted(ShortHelp(command.help)));
  const std::string here = "__fish_seen_subcommand_from " + command.name;
  for (const PositionalEntry& p : command.positionals) {
    text += fmt::format("complete -c stillray -n {} {}", Quoted(here), p.takes_files ? "-F" : "-f");
    if (!p.values.empty()) {
      text += fmt::format(" -a {}", Quoted(fmt::format("{}", fmt::join(p.values, " "))));
    }
    text += "\n";
  }
  for (const OptionEntry& option : command.options) {
    text += FishOption(here, option);
  }
  return text;
}

}  // namespace

std::string BashCompletion(const ProgramEntry& program) {
  std::string text(kBashHead);
  for (const CommandEntry& command : program.commands) {
    text += BashValues(command) + BashCommand(command);
  }
  // The first word is a command.
  text += fmt::format("    :*)\n      options=\"{}\"\n", fmt::join(NamesOf(program.options), " "));
  text += fmt::format("      case \"$word\" in -*) ;; *) _stillray_words {} ;; esac\n      ;;\n",
                      fmt::join(NamesOf(program.commands), " "));
  return text + std::string(kBashTail);
}

std::string ZshCompletion(const ProgramEntry& program) {
  std::string text =
      "#compdef stillray\n"
      "# zsh completion of stillray, written by `stillray completion zsh`.\n"
      "_stillray_values_or_files() {\n"
      "  local expl\n"
      "  _wanted values expl value compadd -- ${@:#-*}\n"
      "  _files\n"
      "}\n"
      "_stillray() {\n"
      "  local curcontext=\"$curcontext\" state line\n"
      "  typeset -A opt_args\n"
      "  local -a commands=(\n";
  for (const CommandEntry& command : program.commands) {
    text += fmt::format("    {}\n", Quoted(command.name + ":" + ShortHelp(command.help)));
  }
  text += "  )\n  _arguments -C \\\n";
  for (const OptionEntry& option : program.options) {
    text += ZshOption(option);
  }
  text +=
      "    '1:command:->command' '*::argument:->argument'\n"
      "  case $state in\n"
      "    command) _describe -t commands command commands ;;\n"
      "    argument)\n      case $words[1] in\n";
  for (const CommandEntry& command : program.commands) {
    text += ZshCommand(command);
  }
  return text +
         "      esac ;;\n"
         "  esac\n"
         "}\n"
         "if [ \"$funcstack[1]\" = _stillray ]; then\n"
         "  _stillray \"$@\"\n"
         "else\n"
         "  compdef _stillray stillray\n"
         "fi\n";
}

std::string FishCompletion(const ProgramEntry& program) {
  std::string text = "# fish completion of stillray, written by `stillray completion fish`.\n";
  for (const OptionEntry& option : program.options) {
    text += FishOption("__fish_use_subcommand", option);
  }
  for (const CommandEntry& command : program.commands) {
    text += FishCommand(command);
  }
  return text;
}

}  // namespace stillray
