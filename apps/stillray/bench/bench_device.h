// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// `stillray bench --device`: the denoiser alone on another device, beside a copy on it.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "benchmarks/device_bench.h"

namespace stillray {

/// One setting at one size.
struct DeviceSubject {
  std::string preset;
  std::string kernel;
  DeviceBenchOptions options;
};

/// Measures them one after the other and prints a table for each.
/// \param device  as Device::Open takes it
/// \param save    called after each with the figures so far: a run that is ended keeps them
Status BenchSubjectsOnDevice(const std::string& device, const std::vector<DeviceSubject>& subjects,
                             const std::function<Status(const nlohmann::ordered_json&)>& save);

}  // namespace stillray
