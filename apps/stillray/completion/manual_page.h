// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The manual page, in roff.
#pragma once

#include <string>

#include "completion/option_tables.h"

namespace stillray {

std::string ManualPage(const ProgramEntry& program, const std::string& version);

}  // namespace stillray
