// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The options of the subcommands that read a sequence of EXR files: the files, and the names of
/// their layers.
#pragma once

#include <string>
#include <vector>

#include "stillray/aov.h"

namespace CLI {
class App;
}

namespace stillray {

/// Adds the files themselves, --frames, --renderer, --view-layer and --aov.
/// \param inputs, frames  for ListSequence
void AddSequenceOptions(CLI::App* command, std::vector<std::string>* inputs, std::string* frames,
                        AovOptions* aovs);

}  // namespace stillray
