// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Options --preset, --settings and --set of all commands that denoise.
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

/// Unparsed option values.
struct FilterArguments {
  std::optional<std::string> preset;  ///< unset: the preset of the settings file, or "default"
  std::string settings_file;          ///< empty: none
  std::vector<std::string> set;       ///< "name=value"
};

struct FilterOptions {
  std::string preset = "default";
  Settings settings;
  std::vector<std::string> set_names;  ///< parameters changed by --set or by the settings file
  RenderLines render;                  ///< render settings of the settings file
};

void AddFilterOptions(CLI::App* command, FilterArguments* arguments);

/// Applies the settings file, then the preset, which replaces the file's parameters, then --set.
/// \return kInvalidArgument naming the option, the value and the expected ones; errors of the file
Result<FilterOptions> ParseFilterArguments(const FilterArguments& arguments);

}  // namespace stillray
