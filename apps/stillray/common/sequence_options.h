// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Options of the subcommands that read a sequence of EXR files: file names and layer names.
#pragma once

#include <string>
#include <vector>

#include "stillray/aov.h"

namespace CLI {
class App;
}

namespace stillray {

/// Adds the positional file arguments, --frames, --renderer, --view-layer and --aov.
/// \param inputs, frames  arguments of ListSequence
void AddSequenceOptions(CLI::App* command, std::vector<std::string>* inputs, std::string* frames,
                        AovOptions* aovs);

}  // namespace stillray
