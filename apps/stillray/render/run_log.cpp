// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "render/run_log.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "common/command_line.h"
#include "common/device_option.h"
#include "common/json_output.h"
#include "common/log_json.h"
#include "common/machine.h"
#include "common/memory_table.h"

namespace stillray {
namespace {

using Json = nlohmann::ordered_json;

Json FrameJson(const FrameLog& frame) {
  return {{"frame", frame.frame},
          {"seconds", frame.seconds},
          {"render_ms", RoundedMs(frame.render_ms)},
          {"denoise_ms", RoundedMs(frame.denoise_ms)},
          {"write_ms", RoundedMs(frame.write_ms)},
          {"stages_ms", StagesJson(frame.stages)}};
}

/// A setting as a JSON value of its type.
Json SettingJson(const RenderSettings& render, const Parameter& p) {
  const std::string value = GetRenderParameter(render, p.name).value();
  switch (p.type) {
    case ParameterType::kFlag:
      return value == "on";
    case ParameterType::kRate:
      return render.cycle > 1 ? Json(SamplesPerPixel(render)) : Json(render.spp);
    case ParameterType::kChoice:
    case ParameterType::kText:
      return value;
    default:
      return Json::parse(value);
  }
}

/// All settings that affect the images of a frame, except the denoiser's parameters.
Json PictureSettings(const RenderOptions& options, const RunLog& log) {
  const RenderArguments& a = options.text;
  Json json = {{"scene", FileNameOf(a.scene)},
               {"scene_content", log.scene_content},
               {"environment", FileNameOf(a.environment)},
               {"environment_content", log.environment_content},
               {"lens_mask", FileNameOf(a.lens_mask)},
               {"lens_mask_content", log.lens_mask_content},
               {"camera", a.camera},
               {"width", options.render.width},
               {"height", options.render.height},
               {"fps", a.fps},
               {"still", a.still},
               {"preset", options.preset},
               {"ray_tracing", a.ray_tracing},
               {"first_hits", a.first_hits},
               {"textures", a.textures},
               {"reference", a.reference_spp},
               {"reference_frames", a.reference_frames},
               {"aov", fmt::format("{}", fmt::join(a.aovs, ","))},
               {"format", a.formats},
               {"float", a.float_exr},
               {"save_inputs", a.save_inputs},
               {"exposure", options.denoise.exposure},
               {"tonemap", GetParameter(options.denoise, "tonemap").value()}};
  if (a.still) {
    // The common moment of all frames.
    json["first_frame"] = options.frames.first;
  }
  for (const Parameter& p : RenderParameters()) {
    json[p.name] = SettingJson(options.render, p);
  }
  json["post"] = PostText(options.post);
  if (options.post.depth_of_field) {
    json["post_aperture"] = GetRenderParameter(options.lens, "aperture").value();
  }
  return json;
}

/// The row of write times, which logs of earlier versions lack.
std::string WriteRow(const RunLog& log) {
  std::vector<double> values;
  for (const FrameLog& frame : log.frames) {
    if (frame.write_ms > 0) {
      values.push_back(frame.write_ms);
    }
  }
  return values.empty() ? "" : TimingsRow("write", values);
}

}  // namespace

std::string RunLogJson(const RenderOptions& options, const RunLog& log, int threads) {
  Json json = {{"stillray", STILLRAY_VERSION}};
  json.update(PictureSettings(options, log));
  json["threads"] = threads;
  json["machine"] = MachineName();
  json["date"] = UtcNow();
  json["device"] = log.device;
  json["tracer"] = log.tracer;
  json["traces_ahead"] = log.traces_ahead;
  json["command"] = CommandLine();
  json["parameters"] = ParametersJson(options.denoise);
  Json frames = Json::array();
  for (const FrameLog& frame : log.frames) {
    frames.push_back(FrameJson(frame));
  }
  json["frames"] = std::move(frames);
  json["memory"] = {{"denoiser_bytes", log.denoiser_bytes},
                    {"renderer_bytes", log.renderer_bytes},
                    {"frame_bytes", log.frame_bytes}};
  if (log.device_memory.allocations > 0) {
    json["memory"]["device"] = DeviceMemoryJson(log.device_memory);
  }
  return JsonText(json);
}

std::vector<FrameLog> FramesOfEarlierRun(const std::string& text, const RenderOptions& options,
                                         const RunLog& log) {
  Result<RunLog> earlier = ParseRunLog(text);
  if (!earlier.ok()) {
    return {};
  }
  const Json was = Json::parse(text);
  // Converted to text and back like the log of the earlier run, so that both have equal JSON types.
  Json is = Json::parse(JsonText(PictureSettings(options, log)));
  is["parameters"] = Json::parse(JsonText(ParametersJson(options.denoise)));
  for (const auto& [key, value] : is.items()) {
    if (!was.contains(key) || was.at(key) != value) {
      return {};
    }
  }
  std::vector<FrameLog>& frames = earlier->frames;
  std::erase_if(frames, [&](const FrameLog& frame) {
    return std::any_of(log.frames.begin(), log.frames.end(),
                       [&](const FrameLog& own) { return own.frame == frame.frame; });
  });
  return std::move(frames);
}

Result<RunLog> ParseRunLog(const std::string& text) {
  Result<std::vector<FrameLog>> frames = ParseFrameLogs<FrameLog>(text, [](const Json& entry) {
    FrameLog frame;
    frame.frame = entry.at("frame").get<int64_t>();
    frame.seconds = entry.at("seconds").get<double>();
    frame.render_ms = entry.at("render_ms").get<double>();
    frame.denoise_ms = entry.at("denoise_ms").get<double>();
    frame.write_ms = entry.value("write_ms", 0.0);
    frame.stages = ParseStages(entry.at("stages_ms"));
    return frame;
  });
  STILLRAY_RETURN_IF_ERROR(frames.status());
  RunLog log;
  log.frames = std::move(frames.value());
  return log;
}

std::string TimingsTable(const RunLog& log) {
  if (log.frames.empty()) {
    return "";
  }
  std::string table = TimingsHead(log.frames.size());
  table += TimingsRow("render", log.frames, [](const FrameLog& f) { return f.render_ms; });
  table += TimingsRow("denoise", log.frames, [](const FrameLog& f) { return f.denoise_ms; });
  table += StageRows(log.frames);
  table += WriteRow(log);
  const std::pair<const char*, size_t> rows[] = {{"memory, denoiser", log.denoiser_bytes},
                                                 {"memory, renderer", log.renderer_bytes},
                                                 {"memory, frames", log.frame_bytes}};
  for (const auto& [name, bytes] : rows) {
    table += fmt::format("  {:<22}{:>10.1f} MB\n", name, static_cast<double>(bytes) / 1e6);
  }
  return table + DeviceMemoryLine(log.device_memory) + MemoryBlocksTable();
}

}  // namespace stillray
