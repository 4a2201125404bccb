// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/denoise_log.h"

#include <algorithm>
#include <array>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "common/device_option.h"
#include "common/finding_json.h"
#include "common/json_output.h"
#include "common/log_json.h"
#include "common/machine.h"

namespace stillray {
namespace {

using Json = nlohmann::ordered_json;

Json FrameJson(const FrameReport& frame) {
  return {{"frame", frame.frame},
          {"input", frame.input},
          {"output", frame.output},
          {"read_ms", RoundedMs(frame.read_ms)},
          {"future_ms", RoundedMs(frame.future_ms)},
          {"denoise_ms", RoundedMs(frame.denoise_ms)},
          {"write_ms", RoundedMs(frame.write_ms)},
          {"elapsed_ms", RoundedMs(frame.elapsed_ms)},
          {"without_history", frame.without_history},
          {"restarted", frame.restarted},
          {"motion", frame.motion},
          {"motion_estimated", frame.motion_estimated},
          {"motion_unknown", frame.motion_unknown},
          {"images_missing", frame.images_missing},
          {"missing_light", frame.missing_light},
          {"negative_light", frame.negative_light},
          {"bad_guides", frame.bad_guides},
          {"stages_ms", StagesJson(frame.stages)}};
}

Json LayoutJson(const AovLayout& layout) {
  Json sources = Json::array();
  for (const AovSource& source : layout.sources) {
    sources.push_back(
        {{"aov", AovName(source.aov)}, {"layer", source.layer}, {"channels", source.channels}});
  }
  for (const std::string& channel : layout.second_moments) {
    if (!channel.empty()) {
      sources.push_back({{"aov", "second_moment"},
                         {"layer", channel.substr(0, channel.rfind('.'))},
                         {"channels", {channel}}});
    }
  }
  return {{"renderer", layout.renderer},
          {"sources", std::move(sources)},
          {"motion", ConventionText(layout.motion)},
          {"depth", ConventionText(layout.depth)},
          {"normal", ConventionText(layout.normal)},
          {"carried", layout.carried},
          {"notes", layout.notes}};
}

/// One of the three steps of a frame (read, filter, write), which may overlap.
struct Part {
  const char* name;
  double milliseconds;  ///< total over all frames
};

std::array<Part, 3> PartsOf(const DenoiseLog& log) {
  std::array<Part, 3> parts = {{{"read", 0}, {"denoise", 0}, {"write", 0}}};
  for (const FrameReport& frame : log.frames) {
    parts[0].milliseconds += frame.read_ms;
    parts[1].milliseconds += frame.future_ms + frame.denoise_ms;
    parts[2].milliseconds += frame.write_ms;
  }
  return parts;
}

const Part& Slowest(const std::array<Part, 3>& parts) {
  return *std::max_element(parts.begin(), parts.end(), [](const Part& a, const Part& b) {
    return a.milliseconds < b.milliseconds;
  });
}

double Elapsed(const DenoiseLog& log) {
  double sum = 0;
  for (const FrameReport& frame : log.frames) {
    sum += frame.elapsed_ms;
  }
  return sum;
}

/// The step that limits the throughput, for which the others wait.
std::string SlowestText(const DenoiseLog& log) {
  const double elapsed = Elapsed(log);
  if (!(elapsed > 0)) {
    return "";
  }
  const std::array<Part, 3> parts = PartsOf(log);
  std::vector<std::string> busy;
  for (const Part& part : parts) {
    busy.push_back(fmt::format("{} {:.0f} %", part.name, 100 * part.milliseconds / elapsed));
  }
  return fmt::format("  slowest part: {} (at work: {} of the time)\n", Slowest(parts).name,
                     fmt::join(busy, ", "));
}

}  // namespace

std::string DenoiseLogJson(const DenoiseOptions& options, const AovLayout& layout,
                           const Settings& used, Window window, const DenoiseLog& log,
                           int threads) {
  Json frames = Json::array();
  for (const FrameReport& frame : log.frames) {
    frames.push_back(FrameJson(frame));
  }
  Json findings = Json::array();
  for (const Finding& finding : log.findings) {
    findings.push_back(FindingJson(finding));
  }
  Json json = {
      {"stillray", STILLRAY_VERSION},       {"preset", options.preset},
      {"window", WindowName(window)},       {"threads", threads},
      {"machine", MachineName()},           {"date", UtcNow()},
      {"aovs", LayoutJson(layout)},         {"findings", std::move(findings)},
      {"parameters", ParametersJson(used)}, {"slowest_part", Slowest(PartsOf(log)).name},
      {"frames", std::move(frames)},        {"memory", {{"denoiser_bytes", log.denoiser_bytes}}}};
  if (options.post.any()) {
    json["post"] = PostText(options.post);
    json["aperture"] = options.text.aperture;
    json["focus"] = options.text.focus;
    json["fov"] = options.text.fov ? Json(*options.text.fov) : Json();
  }
  if (log.device_memory.allocations > 0) {
    json["memory"]["device"] = DeviceMemoryJson(log.device_memory);
  }
  // JSON must be UTF-8, but names from files need not be.
  return JsonText(json);
}

Result<DenoiseLog> ParseDenoiseLog(const std::string& text) {
  const auto parse = [](const Json& entry) {
    FrameReport frame;
    frame.frame = entry.at("frame").get<int64_t>();
    frame.input = entry.at("input").get<std::string>();
    frame.output = entry.at("output").get<std::string>();
    frame.read_ms = entry.at("read_ms").get<double>();
    frame.future_ms = entry.at("future_ms").get<double>();
    frame.denoise_ms = entry.at("denoise_ms").get<double>();
    frame.write_ms = entry.at("write_ms").get<double>();
    frame.elapsed_ms = entry.value("elapsed_ms", 0.0);
    frame.without_history = entry.at("without_history").get<double>();
    frame.restarted = entry.at("restarted").get<bool>();
    frame.motion = entry.value("motion", std::string());
    frame.motion_estimated = entry.value("motion_estimated", 0.0);
    frame.motion_unknown = entry.value("motion_unknown", 0.0);
    frame.images_missing = entry.value("images_missing", std::string());
    frame.missing_light = entry.at("missing_light").get<int64_t>();
    frame.negative_light = entry.value("negative_light", int64_t{0});
    frame.bad_guides = entry.at("bad_guides").get<int64_t>();
    frame.stages = ParseStages(entry.at("stages_ms"));
    return frame;
  };
  Result<std::vector<FrameReport>> frames = ParseFrameLogs<FrameReport>(text, parse);
  STILLRAY_RETURN_IF_ERROR(frames.status());
  DenoiseLog log;
  log.frames = std::move(frames.value());
  try {
    for (const Json& finding : Json::parse(text).value("findings", Json::array())) {
      log.findings.push_back(ParseFinding(finding));
    }
  } catch (const Json::exception& error) {
    return Status::BadData(fmt::format("the log of the run is damaged: {}", error.what()));
  }
  return log;
}

std::string MissingLightWarning(const DenoiseLog& log) {
  int64_t missing = 0;
  int64_t negative = 0;
  for (const FrameReport& frame : log.frames) {
    missing += frame.missing_light;
    negative += frame.negative_light;
  }
  if (missing == 0) {
    return "";
  }
  std::string why;
  if (missing > negative) {
    why = fmt::format("{} are NaN or infinite", missing - negative);
  }
  if (negative > 0) {
    why += fmt::format("{}{} are negative by more than 1/1024 of the mean light",
                       why.empty() ? "" : ", ", negative);
  }
  return fmt::format(
      "warning: {} pixels of light are left out and filled from their neighbours: {}{}; 'stillray "
      "check' shows where they are\n",
      missing, why,
      negative == 0 ? ""
                    : "; noisy light becomes too bright that way: write light that is not a "
                      "difference, with a lossless codec (ZIP) and a pixel filter without negative "
                      "lobes (Box, Blackman-Harris)");
}

std::string MissingImagesWarning(const DenoiseLog& log) {
  std::vector<int64_t> frames;
  for (const FrameReport& frame : log.frames) {
    if (!frame.images_missing.empty()) {
      frames.push_back(frame.frame);
    }
  }
  if (frames.empty()) {
    return "";
  }
  return fmt::format(
      "warning: reflections and what is seen through glass are blurred in {} of {} frames ({}), "
      "whose layers do not determine their motion; a note above names the reason and the cure\n",
      frames.size(), log.frames.size(), FrameRanges(frames));
}

std::string DenoiseTimings(const DenoiseLog& log) {
  if (log.frames.empty()) {
    return "";
  }
  const auto row = [&](const char* name, double FrameReport::*milliseconds) {
    return TimingsRow(name, log.frames,
                      [&](const FrameReport& frame) { return frame.*milliseconds; });
  };
  std::string table = TimingsHead(log.frames.size());
  table += row("read", &FrameReport::read_ms);
  if (std::any_of(log.frames.begin(), log.frames.end(),
                  [](const FrameReport& f) { return f.future_ms > 0; })) {
    table += row("look ahead", &FrameReport::future_ms);
  }
  table += row("denoise", &FrameReport::denoise_ms);
  table += StageRows(log.frames);
  table += row("write", &FrameReport::write_ms);
  table += row("frame to frame", &FrameReport::elapsed_ms);
  table += SlowestText(log);
  return table +
         fmt::format("  {:<22}{:>10.1f} MB\n", "memory, denoiser",
                     static_cast<double>(log.denoiser_bytes) / 1e6) +
         DeviceMemoryLine(log.device_memory);
}

}  // namespace stillray
