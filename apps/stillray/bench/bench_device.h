// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// `stillray bench --device`: times of the denoiser alone on a device, compared with a copy in its
/// memory.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "benchmarks/device_bench.h"

namespace stillray {

/// One configuration of the denoiser at one image size.
struct DeviceSubject {
  std::string preset;
  std::string kernel;
  DeviceBenchOptions options;
};

/// Measures all subjects in sequence and prints one table per subject.
/// \param device  argument of Device::Open
/// \param save    called after each subject with all results so far, so that an interrupted run
///     keeps them
Status BenchSubjectsOnDevice(const std::string& device, const std::vector<DeviceSubject>& subjects,
                             const std::function<Status(const nlohmann::ordered_json&)>& save);

}  // namespace stillray
