// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Settings, times and memory of a run: render.json (docs/report.md) and the table of --timings.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/log_parts.h"
#include "render/render_options.h"
#include "stillray/denoise.hpp"

namespace stillray {

struct FrameLog {
  int64_t frame = 0;
  double seconds = 0;
  double render_ms = 0;
  double denoise_ms = 0;
  double write_ms = 0;
  std::vector<LoggedStage> stages;  ///< stages of renderer and denoiser
};

struct RunLog {
  std::vector<FrameLog> frames;
  std::string scene_content;        ///< checksum of the scene; empty for built-in scenes
  std::string environment_content;  ///< checksum of the environment; empty without --environment
  std::string lens_mask_content;    ///< checksum of the lens mask; empty without --lens-mask
  std::string device;               ///< device of the filter, by name
  std::string tracer;               ///< device of the tracer
  bool traces_ahead = false;        ///< each frame was traced while the previous one was filtered
  size_t denoiser_bytes = 0;
  size_t renderer_bytes = 0;
  size_t frame_bytes = 0;      ///< bytes of all frames that exist concurrently
  DeviceMemory device_memory;  ///< the part of the memory on a GPU
};

/// The text of render.json.
std::string RunLogJson(const RenderOptions& options, const RunLog& log, int threads);

/// Parses the frames of a render.json written by RunLogJson.
/// \return kBadData
Result<RunLog> ParseRunLog(const std::string& json);

/// The frames of an earlier run's render.json that are not part of this run, provided that the
/// earlier run had equal settings: several runs may write to one folder.
/// \param json  arbitrary content
std::vector<FrameLog> FramesOfEarlierRun(const std::string& json, const RenderOptions& options,
                                         const RunLog& log);

/// Median milliseconds of each stage over the frames, and memory, as a table.
std::string TimingsTable(const RunLog& log);

}  // namespace stillray
