// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "view/view_options.h"

#include <charconv>
#include <limits>
#include <string_view>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "common/device_option.h"
#include "common/option_checks.h"
#include "core/nearest_names.h"
#include "io/frame_rate.h"
#include "view/views.h"

namespace stillray::view {
namespace {

constexpr int kLargestSide = 8192;
constexpr int kMostPanes = 3;
constexpr double kFastestOrbit = 720;

template <typename T>
bool ParseWhole(std::string_view text, T* out) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), *out);
  return error == std::errc() && end == text.data() + text.size();
}

Status ParseSize(const std::string& text, ViewSettings* settings) {
  const size_t x = text.find('x');
  const std::string_view all(text);
  const bool parsed = x != std::string::npos && ParseWhole(all.substr(0, x), &settings->width) &&
                      ParseWhole(all.substr(x + 1), &settings->height);
  if (!parsed || settings->width < 16 || settings->height < 16 || settings->width > kLargestSide ||
      settings->height > kLargestSide) {
    return Status::InvalidArgument(fmt::format(
        "--size is '{}', expected WIDTHxHEIGHT with 16 to {} pixels a side", text, kLargestSide));
  }
  return Status::Ok();
}

/// Sets one parameter of RenderParameters(). A number of samples disables the adaptive rate, "auto"
/// enables it.
Status ApplyRenderLine(const RenderLine& line, ViewSettings* settings) {
  const bool is_rate = line.name == "spp";
  if (is_rate && line.value == "auto") {
    settings->auto_rate = true;
    return Status::Ok();
  }
  STILLRAY_RETURN_IF_ERROR(SetRenderParameter(&settings->render, line.name, line.value));
  if (is_rate) {
    settings->auto_rate = false;
    settings->rate = {settings->render.spp, settings->render.cycle};
  }
  return Status::Ok();
}

Status ParseTracer(const ViewArguments& arguments, const RenderLines& file,
                   ViewSettings* settings) {
  for (const RenderLine& line : file) {
    STILLRAY_RETURN_IF_ERROR(ApplyRenderLine(line, settings));
  }
  for (const RenderLine& line : arguments.tracer.given) {
    const Status taken = ApplyRenderLine(line, settings);
    if (!taken.ok()) {
      return Status::InvalidArgument(
          fmt::format("--{}{}", taken.message(), line.name == "spp" ? ", or auto" : ""));
    }
  }
  return Status::Ok();
}

/// Parses the filter options, and the path tracer settings in the settings file.
Status ParseSettings(const ViewArguments& arguments, ViewOptions* options) {
  const Result<FilterOptions> filter = ParseFilterArguments(arguments.filter);
  STILLRAY_RETURN_IF_ERROR(filter.status());
  options->preset = filter->preset;
  options->settings.denoise = filter->settings;
  return ParseTracer(arguments, filter->render, &options->settings);
}

Status ParsePanes(const std::string& text, ViewSettings* settings) {
  const std::vector<ViewInfo> views = ListViews(settings->denoise);
  settings->panes.clear();
  for (std::string_view rest = text; !rest.empty();) {
    const size_t comma = rest.find(',');
    const std::string name(rest.substr(0, comma));
    if (FindView(views, name) == nullptr) {
      std::vector<std::string> names;
      for (const ViewInfo& known : views) {
        names.push_back(known.name);
      }
      return Status::InvalidArgument(fmt::format("--views has '{}', expected 1 to {} of {}{}", name,
                                                 kMostPanes, fmt::join(names, ", "),
                                                 DidYouMeanOneOf(name, names)));
    }
    settings->panes.push_back(name);
    rest.remove_prefix(comma == std::string_view::npos ? rest.size() : comma + 1);
  }
  if (settings->panes.empty() || settings->panes.size() > kMostPanes) {
    return Status::InvalidArgument(
        fmt::format("--views is '{}', expected 1 to {} names", text, kMostPanes));
  }
  for (const std::string& name : settings->panes) {
    settings->reference = settings->reference || name == "reference";
  }
  return Status::Ok();
}

Status ParseRate(const ViewArguments& arguments, ViewSettings* settings) {
  settings->fast_filter = arguments.moving_filter == "psvgf";
  settings->still_converges = arguments.still_history == "all";
  settings->auto_scale = arguments.scale == "auto";
  if (!settings->auto_scale && (!ParseWhole(arguments.scale, &settings->scale) ||
                                !(settings->scale >= 0.05f && settings->scale <= 1.0f))) {
    return Status::InvalidArgument(
        fmt::format("--scale is '{}', expected 0.05 to 1, or auto", arguments.scale));
  }
  settings->target_ms = arguments.target_ms;
  return Status::Ok();
}

/// Parses the options of a run without a window, in which nothing may depend on the clock.
Status ParseHeadless(const ViewArguments& arguments, ViewOptions* options) {
  options->headless_frames = arguments.headless_frames.value_or(0);
  options->folder = arguments.folder;
  if (arguments.headless_frames && !arguments.report.empty()) {
    return Status::InvalidArgument(
        "--report tells of the window's frames and cannot be used with --headless-frames, which "
        "opens none");
  }
  if (!arguments.headless_frames) {
    return arguments.folder.empty()
               ? Status::Ok()
               : Status::InvalidArgument("-o is only used with --headless-frames");
  }
  ViewSettings& settings = options->settings;
  settings.wall_clock = false;
  if (settings.auto_rate) {
    settings.rate = {};
    settings.auto_rate = false;
  }
  if (settings.auto_scale) {
    settings.scale = 1;
    settings.auto_scale = false;
  }
  return Status::Ok();
}

}  // namespace

Status ApplySettingsFile(const SettingsFile& file, ViewSettings* settings) {
  ViewSettings changed = *settings;
  changed.denoise = file.denoise;
  for (const RenderLine& line : file.render) {
    STILLRAY_RETURN_IF_ERROR(ApplyRenderLine(line, &changed));
  }
  *settings = changed;
  return Status::Ok();
}

Result<ViewOptions> ParseViewArguments(const ViewArguments& arguments) {
  ViewOptions options;
  options.request = {arguments.scene, arguments.environment};
  options.threads = arguments.threads;
  options.report = arguments.report;
  ViewSettings& settings = options.settings;
  STILLRAY_RETURN_IF_ERROR(ParseSize(arguments.size, &settings));
  STILLRAY_RETURN_IF_ERROR(ParseSettings(arguments, &options));
  STILLRAY_RETURN_IF_ERROR(ParsePanes(arguments.panes, &settings));
  STILLRAY_RETURN_IF_ERROR(ParseRate(arguments, &settings));
  settings.fps = arguments.fps;
  settings.camera = arguments.camera;
  settings.playing = arguments.play;
  if (arguments.orbit) {
    settings.orbiting = true;
    settings.orbit_speed = *arguments.orbit;
  } else if (arguments.orbit_radius > 0) {
    return Status::InvalidArgument("--orbit-radius needs --orbit SPEED");
  }
  settings.orbit_radius = arguments.orbit_radius;
  STILLRAY_RETURN_IF_ERROR(ParseHeadless(arguments, &options));
  return options;
}

void DeclareViewOptions(CLI::App* command, ViewArguments* a) {
  command->add_option("scene", a->scene, ".gltf, .glb, .obj or builtin:NAME")
      ->capture_default_str();
  command->add_option("--environment", a->environment, "Environment map: .hdr or .exr");
  command->add_option("--size", a->size, "Of the window: WIDTHxHEIGHT in pixels")
      ->capture_default_str();
  AddFilterOptions(command, &a->filter);
  command->add_option("--views", a->panes, "Views side by side: noisy,denoised,reference")
      ->capture_default_str();
  AddTracerOptions(command, &a->tracer);
  CLI::Option* spp = command->get_option("--spp")->default_str("auto");
  spp->description(spp->get_description() + "; auto: as many as --target-ms allows");
  command->add_option("--target-ms", a->target_ms, "Target frame time, for auto")
      ->check(InRange(5, 5000))
      ->capture_default_str();
  command
      ->add_option("--scale", a->scale,
                   "Resolution of the picture: 0.05 to 1, or auto: 1 while it fits")
      ->capture_default_str();
  command
      ->add_option("--moving-filter", a->moving_filter,
                   "Filter while something moves and frames take too long: psvgf, with sparse "
                   "guides, or same: the one chosen")
      ->check(OneOf({"psvgf", "same"}))
      ->capture_default_str();
  command
      ->add_option("--still-history", a->still_history,
                   "History once nothing moves: all, every sample with equal weight, so that the "
                   "picture converges, or same: as the settings have it")
      ->check(OneOf({"all", "same"}))
      ->capture_default_str();
  command->add_option("--camera", a->camera, "Number of the file's camera, from 0")
      ->check(InRange(0, std::numeric_limits<int>::max()))
      ->capture_default_str();
  command->add_option("--fps", a->fps, "Frames per second of clips and single steps")
      ->check(InRange(kMinFps, kMaxFps))
      ->capture_default_str();
  command->add_flag("--play", a->play, "Start the animation at once");
  command
      ->add_option("--orbit", a->orbit,
                   "Circle around what the camera looks at: degrees per second, counter-clockwise "
                   "from above; -720 to 720")
      ->check(InRange(-kFastestOrbit, kFastestOrbit));
  command
      ->add_option("--orbit-radius", a->orbit_radius,
                   "Of --orbit, scene units; default: the camera's distance to what it looks at")
      ->check(InRange(1e-4, 1e6));
  AddDeviceOption(command, &a->device, &a->verbose);
  AddTraceDeviceOption(command, &a->trace_device);
  command->add_option("--threads", a->threads, "Default: all processors")
      ->check(CLI::Range(0, 4096));
  command
      ->add_option("--headless-frames", a->headless_frames,
                   "Without a window: write the picture of each frame to -o")
      ->check(InRange(1, 1'000'000));
  command->add_option("--report", a->report, "Write the window's frame times at the end, as JSON");
  command->add_option("-o,--output", a->folder, "Folder for --headless-frames");
}

}  // namespace stillray::view
