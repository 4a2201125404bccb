// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Times of the denoiser on a device, compared with a copy of its minimum memory traffic.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "stillray/denoise.hpp"

namespace stillray {

/// Formats of the input frames.
enum class BenchInputs : uint8_t {
  kFloat,   ///< 32 bits per value and four values per colour, as written by the path tracer
  kPacked,  ///< formats of real-time renderers: halves, and 8 bits for albedos
};

struct DeviceBenchOptions {
  Settings settings;
  int width = 0;
  int height = 0;
  int repeats = 50;  ///< number of measured submissions
  DevicePrecision precision = DevicePrecision::kHalf;
  BenchInputs inputs = BenchInputs::kFloat;
  double warm_up_ms = 1000;  ///< time that an idle device needs to raise its clock
};

/// All times are in milliseconds, measured by the device, one per repeat.
struct DeviceBenchResult {
  struct Stage {
    std::string name;
    std::vector<double> ms;
  };
  std::string device;         ///< see Device::description
  std::vector<Stage> stages;  ///< stages of the last frame of each submission
  /// Mean time per frame of a submission, including gaps between stages.
  std::vector<double> whole;
  /// Buffer copies with `copy_bytes` total bytes read and written: by vkCmdCopyBuffer, and by a
  /// compute shader. The faster method depends on the driver.
  std::vector<double> transfer_copy;
  std::vector<double> compute_copy;
  uint64_t copy_bytes = 0;
  int copy_bytes_per_pixel = 0;
  int signals = 0;
  int frames_of_a_submission = 1;
  DeviceMemory memory;
  std::vector<std::string> replaced_shaders;  ///< shaders replaced by STILLRAY_SHADER_DIR

  /// The times of the copy method with the lower median.
  const std::vector<double>& copy() const;
};

/// Repeatedly denoises a moving procedural image, several frames per submission, with an equal
/// number of copies. The first frames, which fill caches and histories, are not measured.
/// \param choice  argument of Device::Open, except "cpu" and "auto"
/// \return kUnsupported if the device does not exist or lacks timestamps; errors of the device
Result<DeviceBenchResult> BenchOnDevice(const std::string& choice,
                                        const DeviceBenchOptions& options);

/// A text table: median, minimum, maximum, and ratio to the faster copy.
std::string DeviceBenchTable(const DeviceBenchOptions& options, const DeviceBenchResult& result);

}  // namespace stillray
