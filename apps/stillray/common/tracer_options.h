// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Options of the path tracer, one for each row of RenderParameters(): --spp, --bounces, ...
#pragma once

#include "common/settings_file.h"
#include "stillray/render.h"

namespace CLI {
class App;
}

namespace stillray {

struct TracerArguments {
  RenderSettings defaults;  ///< defaults of the command; set before AddTracerOptions
  RenderLines given;        ///< values from the command line
};

/// Adds --NAME VALUE for numbers and choices, --NAME and --no-NAME for flags.
/// \param arguments  must outlive the parsing of the command line
void AddTracerOptions(CLI::App* command, TracerArguments* arguments);

/// Applies the defaults, then the lines of a settings file, then the command line.
/// \return kInvalidArgument naming the option, the value and what was expected
Result<RenderSettings> ParseTracerArguments(const TracerArguments& arguments,
                                            const RenderLines& file);

}  // namespace stillray
