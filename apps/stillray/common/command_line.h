// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The command line of this process, for logs, so that a run can be repeated.
#pragma once

#include <string>

namespace stillray {

/// Called once, at the start.
void KeepCommandLine(int argc, char** argv);

/// In shell syntax: arguments with characters other than letters, digits and a few marks are
/// quoted. The program's name is without folders.
const std::string& CommandLine();

}  // namespace stillray
