// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// What a run of `stillray denoise` did: the text of --json and the table of --timings.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/log_parts.h"
#include "denoise/denoise_options.h"
#include "stillray/doctor.h"

namespace stillray {

struct DenoisedFrameLog {
  int64_t frame = 0;
  std::string input;
  std::string output;
  double read_ms = 0;
  double future_ms = 0;  ///< playing later frames backward, where that was due
  double denoise_ms = 0;
  double write_ms = 0;
  /// From the end of the frame before, or the run's begin, to its own end. Less than the sum of the
  /// others where they overlap.
  double elapsed_ms = 0;
  /// Part of the pixels with a surface that had no history, 0..1; 1 in the first frame.
  double without_history = 1;
  bool restarted = false;      ///< history was dropped before this frame
  int64_t missing_light = 0;   ///< values that were NaN, infinite or negative, ...
  int64_t negative_light = 0;  ///< ... of these negative
  int64_t bad_guides = 0;      ///< pixels that were passed through
  std::vector<LoggedStage> stages;
  std::string note;  ///< why history was dropped, or empty; told and not kept
};

struct DenoiseLog {
  std::vector<Finding> findings;  ///< of the doctor in the first frames
  std::vector<DenoisedFrameLog> frames;
  size_t denoiser_bytes = 0;
  DeviceMemory device_memory;  ///< of that what lies on a GPU
};

std::string DenoiseLogJson(const DenoiseOptions& options, const AovLayout& layout,
                           const Settings& used, const DenoiseLog& log, int threads);
/// Frames and findings of a text that DenoiseLogJson made. \return kBadData
Result<DenoiseLog> ParseDenoiseLog(const std::string& json);
/// One line that says how much light was left out, why, and what helps; empty where none was.
std::string MissingLightWarning(const DenoiseLog& log);
/// Median, least and most milliseconds of every step, and memory.
std::string DenoiseTimings(const DenoiseLog& log);

}  // namespace stillray
