// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The command line of this process, stored in logs to make runs reproducible.
#pragma once

#include <string>

namespace stillray {

/// Stores the command line; call once, at program start.
void KeepCommandLine(int argc, char** argv);

/// The command line in shell syntax: arguments with special characters are quoted. The program name
/// is without folders.
const std::string& CommandLine();

}  // namespace stillray
