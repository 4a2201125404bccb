// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "run_log.h"

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

double Median(std::vector<double> values) {
  if (values.empty()) {
    return 0;
  }
  std::sort(values.begin(), values.end());
  const size_t middle = values.size() / 2;
  return values.size() % 2 == 1 ? values[middle] : (values[middle - 1] + values[middle]) / 2;
}

Json FrameJson(const FrameLog& frame) {
  Json stages = Json::object();
  for (const StageTime& stage : frame.stages) {
    stages[stage.name] = Rounded(stage.milliseconds);
  }
  return {{"frame", frame.frame},
          {"seconds", frame.seconds},
          {"render_ms", Rounded(frame.render_ms)},
          {"denoise_ms", Rounded(frame.denoise_ms)},
          {"stages_ms", std::move(stages)}};
}

Json ParametersJson(const Settings& settings) {
  Json parameters = Json::object();
  for (const Parameter& p : Parameters()) {
    parameters[p.name] = GetParameter(settings, p.name).value();
  }
  return parameters;
}

void AddRow(const std::string& name, const std::vector<double>& values, std::string* table) {
  *table += fmt::format("  {:<22}{:>10.2f}{:>10.2f}{:>10.2f}\n", name, Median(values),
                        *std::min_element(values.begin(), values.end()),
                        *std::max_element(values.begin(), values.end()));
}

}  // namespace

std::string RunLogJson(const RenderOptions& options, const RunLog& log, int threads) {
  const RenderArguments& a = options.text;
  Json json = {{"stillray", STILLRAY_VERSION},
               {"scene", a.scene},
               {"width", options.render.width},
               {"height", options.render.height},
               {"fps", a.fps},
               {"spp", a.spp},
               {"bounces", a.bounces},
               {"preset", a.preset},
               {"seed", a.seed},
               {"sampler", a.sampler},
               {"threads", threads},
               {"exposure", options.denoise.exposure},
               {"tonemap", GetParameter(options.denoise, "tonemap").value()},
               {"parameters", ParametersJson(options.denoise)}};
  Json frames = Json::array();
  for (const FrameLog& frame : log.frames) {
    frames.push_back(FrameJson(frame));
  }
  json["frames"] = std::move(frames);
  json["memory"] = {{"denoiser_bytes", log.denoiser_bytes}, {"renderer_bytes", log.renderer_bytes}};
  return json.dump(1) + "\n";
}

Result<RunLog> ParseRunLog(const std::string& text) {
  RunLog log;
  try {
    const Json json = Json::parse(text);
    for (const Json& entry : json.at("frames")) {
      FrameLog frame;
      frame.frame = entry.at("frame").get<int64_t>();
      frame.seconds = entry.at("seconds").get<double>();
      frame.render_ms = entry.at("render_ms").get<double>();
      frame.denoise_ms = entry.at("denoise_ms").get<double>();
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

std::string TimingsTable(const RunLog& log) {
  if (log.frames.empty()) {
    return "";
  }
  std::string table =
      fmt::format("  {:<22}{:>10}{:>10}{:>10}\n", fmt::format("ms, {} frames", log.frames.size()),
                  "median", "min", "max");
  const auto column = [&](const auto& value) {
    std::vector<double> values;
    for (const FrameLog& frame : log.frames) {
      values.push_back(value(frame));
    }
    return values;
  };
  AddRow("render", column([](const FrameLog& f) { return f.render_ms; }), &table);
  AddRow("denoise", column([](const FrameLog& f) { return f.denoise_ms; }), &table);
  // The last frame has the stages that need a history too.
  for (const StageTime& stage : log.frames.back().stages) {
    AddRow("  " + stage.name, column([&](const FrameLog& f) {
             const auto at = std::find_if(f.stages.begin(), f.stages.end(),
                                          [&](const StageTime& s) { return s.name == stage.name; });
             return at == f.stages.end() ? 0.0 : at->milliseconds;
           }),
           &table);
  }
  table += fmt::format("  {:<22}{:>10.1f} MB\n  {:<22}{:>10.1f} MB\n", "memory, denoiser",
                       static_cast<double>(log.denoiser_bytes) / 1e6, "memory, renderer",
                       static_cast<double>(log.renderer_bytes) / 1e6);
  return table;
}

}  // namespace stillray
