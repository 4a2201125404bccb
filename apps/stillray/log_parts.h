// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// What the logs of all commands that denoise have in common: JSON of stages and settings, and the
/// rows of the table of --timings.
#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "stillray/denoise.hpp"

namespace stillray {

/// Rounded to what a clock can tell, so that files stay readable.
inline double RoundedMs(double milliseconds) {
  return std::round(milliseconds * 1000) / 1000;
}

/// What a log keeps of a stage: logs are also read from files, where names are no literals.
struct LoggedStage {
  std::string name;
  double milliseconds = 0;
};

inline std::vector<LoggedStage> LoggedStages(const std::vector<StageTime>& timings) {
  std::vector<LoggedStage> stages;
  for (const StageTime& stage : timings) {
    stages.push_back({std::string(stage.name), stage.milliseconds});
  }
  return stages;
}

inline nlohmann::ordered_json StagesJson(const std::vector<LoggedStage>& stages) {
  nlohmann::ordered_json json = nlohmann::ordered_json::object();
  for (const LoggedStage& stage : stages) {
    json[stage.name] = RoundedMs(stage.milliseconds);
  }
  return json;
}

/// What StagesJson wrote. Throws what the JSON library throws at other things.
inline std::vector<LoggedStage> ParseStages(const nlohmann::ordered_json& json) {
  std::vector<LoggedStage> stages;
  for (const auto& [name, milliseconds] : json.items()) {
    stages.push_back({name, milliseconds.get<double>()});
  }
  return stages;
}

/// The frames of a log of a run.
/// \param parse  takes the JSON of one frame; may throw what the JSON library throws
template <typename FrameLog, typename Parse>
Result<std::vector<FrameLog>> ParseFrameLogs(const std::string& text, const Parse& parse) {
  std::vector<FrameLog> frames;
  try {
    const auto json = nlohmann::ordered_json::parse(text);
    for (const auto& entry : json.at("frames")) {
      frames.push_back(parse(entry));
    }
  } catch (const nlohmann::ordered_json::exception& error) {
    return Status::BadData(fmt::format("the log of the run is damaged: {}", error.what()));
  }
  return frames;
}

inline nlohmann::ordered_json ParametersJson(const Settings& settings) {
  nlohmann::ordered_json json = nlohmann::ordered_json::object();
  for (const Parameter& p : Parameters()) {
    json[p.name] = GetParameter(settings, p.name).value();
  }
  return json;
}

/// The first row of the table.
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
/// \param value   takes the log of a frame
template <typename FrameLogs, typename Value>
std::string TimingsRow(const std::string& name, const FrameLogs& frames, const Value& value) {
  std::vector<double> values;
  for (const auto& frame : frames) {
    values.push_back(value(frame));
  }
  return TimingsRow(name, std::move(values));
}

/// One row per stage of the last frame, which has the stages that need a history too.
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
