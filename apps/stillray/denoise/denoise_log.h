// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The log of a run of `stillray denoise`: the text of --json and the table of --timings.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/log_parts.h"
#include "denoise/denoise_options.h"
#include "stillray/doctor.h"
#include "stillray/sequence.h"

namespace stillray {

struct DenoiseLog {
  std::vector<Finding> findings;  ///< the doctor's findings in the first frames
  std::vector<FrameReport> frames;
  size_t denoiser_bytes = 0;
  DeviceMemory device_memory;  ///< the part of the memory on a GPU
};

std::string DenoiseLogJson(const DenoiseOptions& options, const AovLayout& layout,
                           const Settings& used, Window window, const DenoiseLog& log, int threads);
/// Parses frames and findings from the output of DenoiseLogJson. \return kBadData
Result<DenoiseLog> ParseDenoiseLog(const std::string& json);
/// One line about radiance that was treated as missing, the cause, and the remedy; empty if there
/// was none.
std::string MissingLightWarning(const DenoiseLog& log);
/// One line about frames whose reflections are blurred (FrameReport::images_missing), or empty.
std::string MissingImagesWarning(const DenoiseLog& log);
/// Median, minimum and maximum milliseconds of every step, and memory.
std::string DenoiseTimings(const DenoiseLog& log);

}  // namespace stillray
