// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// --preset, --settings and --set of every command that denoises.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/settings_file.h"
#include "stillray/denoise.hpp"

namespace CLI {
class App;
}

namespace stillray {

/// As the user gave them.
struct FilterArguments {
  std::optional<std::string> preset;  ///< none: the file's, or "default"
  std::string settings_file;          ///< empty: none
  std::vector<std::string> set;       ///< "name=value"
};

struct FilterOptions {
  std::string preset = "default";
  Settings settings;
  std::vector<std::string> set_names;  ///< parameters of --set, and those that the file changes
  RenderLines render;                  ///< of the file
};

void AddFilterOptions(CLI::App* command, FilterArguments* arguments);

/// Applies the file first, then a preset that replaces it, then single parameters.
/// \return kInvalidArgument naming the option, the value and the expected ones; errors of the file
Result<FilterOptions> ParseFilterArguments(const FilterArguments& arguments);

}  // namespace stillray
