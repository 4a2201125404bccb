// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Where and when a run was made, for its log.
#pragma once

#include <string>

namespace stillray {

/// "Intel(R) Xeon(R) CPU @ 2.20GHz, 8 threads": the processor and how many threads it runs at once.
std::string MachineName();

/// "2026-03-01T12:00:00Z"
std::string UtcNow();

}  // namespace stillray
