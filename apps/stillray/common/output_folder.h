// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The folder that files are written into.
#pragma once

#include <string>

#include "stillray/status.h"

namespace stillray {

/// Makes the folder, and those above it, where they are not there yet. "" is the current one.
/// \return kIo naming the folder and why it could not be made
Status MakeOutputFolder(const std::string& folder);

}  // namespace stillray
