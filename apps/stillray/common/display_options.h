// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// --exposure and --tonemap of every command that makes display pictures.
#pragma once

#include <optional>
#include <string>

#include "stillray/denoise.hpp"

namespace CLI {
class App;
}

namespace stillray {

/// As the user gave them; none: what the settings have.
struct DisplayArguments {
  std::optional<double> exposure;
  std::optional<std::string> tonemap;
};

void AddDisplayOptions(CLI::App* command, DisplayArguments* arguments);

/// \return kInvalidArgument naming the option, the value and what was expected
Status SetDisplay(const DisplayArguments& arguments, Settings* settings);

}  // namespace stillray
