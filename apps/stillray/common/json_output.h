// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// JSON of every command: its text, and --json FILE.
#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include "stillray/status.h"

namespace stillray {

/// The text of a log or a result, with a line end. Names of files, scenes and layers may hold any
/// bytes, as JSON may not: what is not valid UTF-8 becomes U+FFFD.
/// \param indent  blanks per level
std::string JsonText(const nlohmann::ordered_json& json, int indent = 1);

/// Finds before the work, not after it, that the file of --json cannot be written. Makes nothing.
/// \param path  "-" and "" are always right
/// \return kNotFound (no such folder), kIo (a folder; no right to write), naming option and path
Status CheckJsonOutput(const std::string& path);

/// Writes the text whole to the file, or to standard output if `path` is "-".
Status WriteJsonOutput(const std::string& path, const std::string& json);

}  // namespace stillray
