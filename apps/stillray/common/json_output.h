// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// JSON output of all commands: text, and the option --json FILE.
#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include "stillray/status.h"

namespace stillray {

/// Serialises a log or result, with a newline at the end. Names of files, scenes and layers may
/// contain arbitrary bytes: invalid UTF-8 is replaced by U+FFFD.
/// \param indent  blanks per level
std::string JsonText(const nlohmann::ordered_json& json, int indent = 1);

/// JSON has neither infinity nor NaN: both become null.
nlohmann::ordered_json JsonNumber(double value);

/// Checks in advance that the file of --json can be written, without creating it.
/// \param path  "-" and "" are always valid
/// \return kNotFound (no such folder), kIo (a folder; no permission to write), naming option and
///     path
Status CheckJsonOutput(const std::string& path);

/// Writes the whole text to the file, or to standard output if `path` is "-".
Status WriteJsonOutput(const std::string& path, const std::string& json);

}  // namespace stillray
