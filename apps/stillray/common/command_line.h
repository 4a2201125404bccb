// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The command line of this process, for logs: who reads one can repeat the run.
#pragma once

#include <string>

namespace stillray {

/// Called once, at the start.
void KeepCommandLine(int argc, char** argv);

/// As a shell would read it: arguments with other characters than letters, digits and a few marks
/// stand in quotes. The program has its name without folders.
const std::string& CommandLine();

}  // namespace stillray
