// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Times of the denoiser on a device, beside a copy of the least bytes that it must touch.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "stillray/denoise.hpp"

namespace stillray {

struct DeviceBenchOptions {
  Settings settings;
  int width = 0;
  int height = 0;
  int repeats = 50;
  DevicePrecision precision = DevicePrecision::kHalf;
};

/// All times in milliseconds, measured by the device, one per repeat.
struct DeviceBenchResult {
  struct Stage {
    std::string name;
    std::vector<double> ms;
  };
  std::string device;  ///< see Device::description
  std::vector<Stage> stages;
  std::vector<double> whole;  ///< sums of the stages
  std::vector<double> copy;   ///< from buffer to buffer, of `copy_bytes` in all read and written
  uint64_t copy_bytes = 0;
  int copy_bytes_per_pixel = 0;
  int signals = 0;
  DeviceMemory memory;
};

/// Denoises a moving picture made by formula again and again; after each frame, the copy. The first
/// frames, which fill caches and histories, do not count.
/// \param choice  as Device::Open takes it, but for "cpu" and "auto"
/// \return kUnsupported if there is no such device, or it has no timestamps; errors of the device
Result<DeviceBenchResult> BenchOnDevice(const std::string& choice,
                                        const DeviceBenchOptions& options);

/// A table for people: medians, least and largest, the ratio to the copy.
std::string DeviceBenchTable(const DeviceBenchOptions& options, const DeviceBenchResult& result);

}  // namespace stillray
