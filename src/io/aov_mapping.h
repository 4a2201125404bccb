// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The text of --aov.
#pragma once

#include <string>
#include <vector>

#include "stillray/aov.h"

namespace stillray::io {

/// "normal=MyNormals,encoded,channels=RGB", split into its parts.
struct AovMapping {
  Aov aov = Aov::kColour;
  std::string layer;
  std::string channels;            ///< letters; empty: the layer's channels with the usual letters
  std::vector<std::string> words;  ///< of the convention, unparsed
};

/// \return kInvalidArgument
Result<AovMapping> ParseAovMapping(const std::string& text);

/// Applies the mapping's words to the convention of its AOV.
/// \return kInvalidArgument naming the word and the allowed ones
Status ApplyWords(const AovMapping& mapping, AovLayout* layout);

}  // namespace stillray::io
