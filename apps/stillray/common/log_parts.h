// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Common parts of the logs of all commands that denoise: stages, and the rows of the table of
/// --timings. log_json.h has their JSON.
#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "stillray/denoise.hpp"
#include "stillray/sequence.h"

namespace stillray {

/// Rounded to the precision of a clock, so that files stay readable.
inline double RoundedMs(double milliseconds) {
  return std::round(milliseconds * 1000) / 1000;
}

/// The heading of the table.
inline std::string TimingsHead(size_t frames) {
  return fmt::format("  {:<22}{:>10}{:>10}{:>10}\n", fmt::format("ms, {} frames", frames), "median",
                     "min", "max");
}

/// \param values  milliseconds, one per frame, not empty
inline std::string TimingsRow(const std::string& name, std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const size_t middle = values.size() / 2;
  const double median =
      values.size() % 2 == 1 ? values[middle] : (values[middle - 1] + values[middle]) / 2;
  return fmt::format("  {:<22}{:>10.2f}{:>10.2f}{:>10.2f}\n", name, median, values.front(),
                     values.back());
}

/// \param frames  not empty
/// \param value   returns the value of a frame's log
template <typename FrameLogs, typename Value>
std::string TimingsRow(const std::string& name, const FrameLogs& frames, const Value& value) {
  std::vector<double> values;
  for (const auto& frame : frames) {
    values.push_back(value(frame));
  }
  return TimingsRow(name, std::move(values));
}

/// One row per stage of the last frame, which includes the stages that need a history.
/// \param frames  with a member `stages`, not empty
template <typename FrameLogs>
std::string StageRows(const FrameLogs& frames) {
  std::string rows;
  for (const LoggedStage& stage : frames.back().stages) {
    rows += TimingsRow("  " + stage.name, frames, [&](const auto& frame) {
      const auto at = std::find_if(frame.stages.begin(), frame.stages.end(),
                                   [&](const LoggedStage& s) { return s.name == stage.name; });
      return at == frame.stages.end() ? 0.0 : at->milliseconds;
    });
  }
  return rows;
}

}  // namespace stillray
