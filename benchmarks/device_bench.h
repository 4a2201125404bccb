// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Times of the denoiser on a device, beside a copy of the least bytes that it must touch.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "stillray/denoise.hpp"

namespace stillray {

/// Formats of the frames that are denoised.
enum class BenchInputs : uint8_t {
  kFloat,   ///< 32 bits per value and four values per colour, as the path tracer writes them
  kPacked,  ///< as a real-time renderer keeps them: halves, and 8 bits for albedos
};

struct DeviceBenchOptions {
  Settings settings;
  int width = 0;
  int height = 0;
  int repeats = 50;  ///< submissions that are measured
  DevicePrecision precision = DevicePrecision::kHalf;
  BenchInputs inputs = BenchInputs::kFloat;
  double warm_up_ms = 1000;  ///< an idle device takes that long to raise its clock
};

/// All times in milliseconds, measured by the device, one per repeat.
struct DeviceBenchResult {
  struct Stage {
    std::string name;
    std::vector<double> ms;
  };
  std::string device;         ///< see Device::description
  std::vector<Stage> stages;  ///< of the last frame of each submission
  std::vector<double> whole;  ///< mean of the frames of a submission, with what lies between stages
  /// From buffer to buffer, of `copy_bytes` in all read and written: by vkCmdCopyBuffer, and by a
  /// compute shader. Which is faster depends on the driver.
  std::vector<double> transfer_copy;
  std::vector<double> compute_copy;
  uint64_t copy_bytes = 0;
  int copy_bytes_per_pixel = 0;
  int signals = 0;
  int frames_of_a_submission = 1;
  DeviceMemory memory;
  std::vector<std::string> replaced_shaders;  ///< by STILLRAY_SHADER_DIR

  /// The times of the faster copy, by the medians.
  const std::vector<double>& copy() const;
};

/// Denoises a moving picture made by formula again and again, several frames per submission, and
/// copies as often. The first frames, which fill caches and histories, do not count.
/// \param choice  as Device::Open takes it, but for "cpu" and "auto"
/// \return kUnsupported if there is no such device, or it has no timestamps; errors of the device
Result<DeviceBenchResult> BenchOnDevice(const std::string& choice,
                                        const DeviceBenchOptions& options);

/// A table for people: medians, least and largest, the ratio to the faster copy.
std::string DeviceBenchTable(const DeviceBenchOptions& options, const DeviceBenchResult& result);

}  // namespace stillray
