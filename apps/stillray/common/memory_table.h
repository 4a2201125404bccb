// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Table of the memory of all images of the process, on the CPU and on devices, for `bench --fps`
/// and --timings.
#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

namespace stillray {

/// One row for the CPU, one for devices that hold images, and their sum.
std::string MemoryBlocksTable();
nlohmann::ordered_json MemoryBlocksJson();

}  // namespace stillray
