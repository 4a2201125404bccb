// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Options --exposure and --tonemap of all commands that write display images.
#pragma once

#include <optional>
#include <string>

#include "stillray/denoise.hpp"

namespace CLI {
class App;
}

namespace stillray {

/// Unparsed option values; unset options keep the settings.
struct DisplayArguments {
  std::optional<double> exposure;
  std::optional<std::string> tonemap;
};

void AddDisplayOptions(CLI::App* command, DisplayArguments* arguments);

/// \return kInvalidArgument naming the option, its value and the expected ones
Status SetDisplay(const DisplayArguments& arguments, Settings* settings);

}  // namespace stillray
