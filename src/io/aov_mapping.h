// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The text of --aov.
#pragma once

#include <string>
#include <vector>

#include "stillray/aov.h"

namespace stillray::io {

/// "normal=MyNormals,encoded,channels=RGB", taken apart.
struct AovMapping {
  Aov aov = Aov::kColour;
  std::string layer;
  std::string channels;            ///< letters, or empty: whichever usual ones the layer has
  std::vector<std::string> words;  ///< of the convention, not yet understood
};

/// \return kInvalidArgument
Result<AovMapping> ParseAovMapping(const std::string& text);

/// Changes the convention of the mapping's AOV as its words say.
/// \return kInvalidArgument naming the word and what is allowed
Status ApplyWords(const AovMapping& mapping, AovLayout* layout);

}  // namespace stillray::io
