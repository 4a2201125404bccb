// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise_log.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace stillray {
namespace {

using Json = nlohmann::ordered_json;

/// Rounded to what a clock can tell, so that files stay readable.
double Rounded(double milliseconds) {
  return std::round(milliseconds * 1000) / 1000;
}

Json FrameJson(const DenoisedFrameLog& frame) {
  Json stages = Json::object();
  for (const StageTime& stage : frame.stages) {
    stages[stage.name] = Rounded(stage.milliseconds);
  }
  return {{"frame", frame.frame},
          {"input", frame.input},
          {"output", frame.output},
          {"read_ms", Rounded(frame.read_ms)},
          {"denoise_ms", Rounded(frame.denoise_ms)},
          {"write_ms", Rounded(frame.write_ms)},
          {"without_history", frame.without_history},
          {"restarted", frame.restarted},
          {"missing_light", frame.missing_light},
          {"bad_guides", frame.bad_guides},
          {"stages_ms", std::move(stages)}};
}

Json LayoutJson(const AovLayout& layout) {
  Json sources = Json::array();
  for (const AovSource& source : layout.sources) {
    sources.push_back(
        {{"aov", AovName(source.aov)}, {"layer", source.layer}, {"channels", source.channels}});
  }
  return {{"renderer", layout.renderer},
          {"sources", std::move(sources)},
          {"motion", ConventionText(layout.motion)},
          {"depth", ConventionText(layout.depth)},
          {"normal", ConventionText(layout.normal)},
          {"carried", layout.carried},
          {"notes", layout.notes}};
}

void AddRow(const std::string& name, std::vector<double> values, std::string* table) {
  std::sort(values.begin(), values.end());
  *table += fmt::format("  {:<22}{:>10.2f}{:>10.2f}{:>10.2f}\n", name, values[values.size() / 2],
                        values.front(), values.back());
}

}  // namespace

std::string DenoiseLogJson(const DenoiseOptions& options, const AovLayout& layout,
                           const Settings& used, const DenoiseLog& log, int threads) {
  Json parameters = Json::object();
  for (const Parameter& p : Parameters()) {
    parameters[p.name] = GetParameter(used, p.name).value();
  }
  Json frames = Json::array();
  for (const DenoisedFrameLog& frame : log.frames) {
    frames.push_back(FrameJson(frame));
  }
  const Json json = {{"stillray", STILLRAY_VERSION},
                     {"preset", options.text.preset},
                     {"threads", threads},
                     {"aovs", LayoutJson(layout)},
                     {"parameters", std::move(parameters)},
                     {"frames", std::move(frames)},
                     {"memory", {{"denoiser_bytes", log.denoiser_bytes}}}};
  // Names from files need not be UTF-8, as JSON must be.
  return json.dump(1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

Result<DenoiseLog> ParseDenoiseLog(const std::string& text) {
  DenoiseLog log;
  try {
    const Json json = Json::parse(text);
    for (const Json& entry : json.at("frames")) {
      DenoisedFrameLog frame;
      frame.frame = entry.at("frame").get<int64_t>();
      frame.input = entry.at("input").get<std::string>();
      frame.output = entry.at("output").get<std::string>();
      frame.read_ms = entry.at("read_ms").get<double>();
      frame.denoise_ms = entry.at("denoise_ms").get<double>();
      frame.write_ms = entry.at("write_ms").get<double>();
      frame.without_history = entry.at("without_history").get<double>();
      frame.restarted = entry.at("restarted").get<bool>();
      frame.missing_light = entry.at("missing_light").get<int64_t>();
      frame.bad_guides = entry.at("bad_guides").get<int64_t>();
      for (const auto& [name, milliseconds] : entry.at("stages_ms").items()) {
        frame.stages.push_back({name, milliseconds.get<double>()});
      }
      log.frames.push_back(std::move(frame));
    }
  } catch (const Json::exception& error) {
    return Status::BadData(fmt::format("the log of the run is damaged: {}", error.what()));
  }
  return log;
}

std::string DenoiseTimings(const DenoiseLog& log) {
  if (log.frames.empty()) {
    return "";
  }
  std::string table =
      fmt::format("  {:<22}{:>10}{:>10}{:>10}\n", fmt::format("ms, {} frames", log.frames.size()),
                  "median", "min", "max");
  const auto column = [&](const auto& value) {
    std::vector<double> values;
    for (const DenoisedFrameLog& frame : log.frames) {
      values.push_back(value(frame));
    }
    return values;
  };
  AddRow("read", column([](const DenoisedFrameLog& f) { return f.read_ms; }), &table);
  AddRow("denoise", column([](const DenoisedFrameLog& f) { return f.denoise_ms; }), &table);
  // The last frame has the stages that need a history too.
  for (const StageTime& stage : log.frames.back().stages) {
    AddRow("  " + stage.name, column([&](const DenoisedFrameLog& f) {
             const auto at = std::find_if(f.stages.begin(), f.stages.end(),
                                          [&](const StageTime& s) { return s.name == stage.name; });
             return at == f.stages.end() ? 0.0 : at->milliseconds;
           }),
           &table);
  }
  AddRow("write", column([](const DenoisedFrameLog& f) { return f.write_ms; }), &table);
  return table + fmt::format("  {:<22}{:>10.1f} MB\n", "memory, denoiser",
                             static_cast<double>(log.denoiser_bytes) / 1e6);
}

}  // namespace stillray
