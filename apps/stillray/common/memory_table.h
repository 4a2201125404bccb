// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The memory of all pictures of the process, on the CPU and on devices: of `bench --fps` and
/// --timings.
#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

namespace stillray {

/// One row each for the CPU and, if they hold any, devices, and their sum.
std::string MemoryBlocksTable();
nlohmann::ordered_json MemoryBlocksJson();

}  // namespace stillray
