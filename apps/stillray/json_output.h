// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// --json FILE of every command.
#pragma once

#include <string>

#include "stillray/status.h"

namespace stillray {

/// Writes the text whole to the file, or to standard output if `path` is "-".
Status WriteJsonOutput(const std::string& path, const std::string& json);

}  // namespace stillray
