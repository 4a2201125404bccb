// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The folder of output files.
#pragma once

#include <string>

#include "stillray/status.h"

namespace stillray {

/// Creates the folder and its parents if necessary. "" is the current one.
/// \return kIo naming the folder and the reason
Status MakeOutputFolder(const std::string& folder);

}  // namespace stillray
