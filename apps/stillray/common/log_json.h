// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// JSON of stages, frames and settings, common to the logs of all commands that denoise.
#pragma once

#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "common/log_parts.h"
#include "stillray/denoise.hpp"

namespace stillray {

inline nlohmann::ordered_json StagesJson(const std::vector<LoggedStage>& stages) {
  nlohmann::ordered_json json = nlohmann::ordered_json::object();
  for (const LoggedStage& stage : stages) {
    json[stage.name] = RoundedMs(stage.milliseconds);
  }
  return json;
}

/// Parses the output of StagesJson. Throws the JSON library's exceptions on other input.
inline std::vector<LoggedStage> ParseStages(const nlohmann::ordered_json& json) {
  std::vector<LoggedStage> stages;
  for (const auto& [name, milliseconds] : json.items()) {
    stages.push_back({name, milliseconds.get<double>()});
  }
  return stages;
}

/// Parses the frames of a run's log.
/// \param parse  converts the JSON of one frame; may throw the JSON library's exceptions
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

}  // namespace stillray
