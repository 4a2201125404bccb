// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Scripts that complete the command line in shells.
#pragma once

#include <string>

#include "completion/option_tables.h"

namespace stillray {

std::string BashCompletion(const ProgramEntry& program);
std::string ZshCompletion(const ProgramEntry& program);
std::string FishCompletion(const ProgramEntry& program);

}  // namespace stillray
