// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Machine and time of a run, for its log.
#pragma once

#include <string>

namespace stillray {

/// "Intel(R) Xeon(R) CPU @ 2.20GHz, 8 threads": the processor and its number of hardware threads.
std::string MachineName();

/// "2026-03-01T12:00:00Z"
std::string UtcNow();

}  // namespace stillray
