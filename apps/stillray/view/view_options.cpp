// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "view/view_options.h"

#include <charconv>
#include <string_view>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "common/device_option.h"
#include "io/frame_rate.h"
#include "view/views.h"

namespace stillray::view {
namespace {

constexpr int kLargestSide = 8192;
constexpr int kMostPanes = 3;

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

/// Applies a file first, then a preset that replaces it, then single parameters.
Status ParseDenoise(const ViewArguments& arguments, ViewOptions* options) {
  Settings* settings = &options->settings.denoise;
  options->preset = "default";
  if (!arguments.settings_file.empty()) {
    Result<SettingsFile> file = ReadSettingsFile(arguments.settings_file);
    if (!file.ok()) {
      return Status(file.status().code(), "--settings: " + file.status().message());
    }
    ApplySettingsFile(file.value(), &options->settings);
    options->preset = file->preset;
  }
  if (arguments.preset) {
    Result<Settings> preset = PresetSettings(*arguments.preset);
    if (!preset.ok()) {
      return Status::InvalidArgument("--preset: " + preset.status().message());
    }
    *settings = preset.value();
    options->preset = *arguments.preset;
  }
  for (const std::string& assignment : arguments.set) {
    const size_t equals = assignment.find('=');
    if (equals == std::string::npos) {
      return Status::InvalidArgument(fmt::format("--set is '{}', expected name=value", assignment));
    }
    const Status set =
        SetParameter(settings, assignment.substr(0, equals), assignment.substr(equals + 1));
    if (!set.ok()) {
      return Status::InvalidArgument("--set: " + set.message());
    }
  }
  return ValidateSettings(*settings);
}

Status ParsePanes(const std::string& text, ViewSettings* settings) {
  const std::vector<ViewInfo> views = ListViews(settings->denoise);
  settings->panes.clear();
  for (std::string_view rest = text; !rest.empty();) {
    const size_t comma = rest.find(',');
    const std::string name(rest.substr(0, comma));
    if (FindView(views, name) == nullptr) {
      std::string names;
      for (const ViewInfo& view : views) {
        names += (names.empty() ? "" : ", ") + view.name;
      }
      return Status::InvalidArgument(
          fmt::format("--views has '{}', expected 1 to 3 of {}", name, names));
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
  if (arguments.spp) {
    settings->auto_rate = *arguments.spp == "auto";
  }
  if (arguments.spp && !settings->auto_rate) {
    Result<SampleRate> rate = ParseSampleRate(*arguments.spp);
    if (!rate.ok()) {
      return Status::InvalidArgument("--spp: " + rate.status().message() + ", or auto");
    }
    settings->rate = rate.value();
  }
  if (arguments.moving_filter != "psvgf" && arguments.moving_filter != "same") {
    return Status::InvalidArgument(
        fmt::format("--moving-filter is '{}', expected psvgf or same", arguments.moving_filter));
  }
  settings->fast_filter = arguments.moving_filter == "psvgf";
  settings->auto_scale = arguments.scale == "auto";
  if (!settings->auto_scale && (!ParseWhole(arguments.scale, &settings->scale) ||
                                !(settings->scale >= 0.05f && settings->scale <= 1.0f))) {
    return Status::InvalidArgument(
        fmt::format("--scale is '{}', expected 0.05 to 1, or auto", arguments.scale));
  }
  if (!(arguments.target_ms >= 5 && arguments.target_ms <= 5000)) {
    return Status::InvalidArgument(
        fmt::format("--target-ms is {}, expected 5 to 5000", arguments.target_ms));
  }
  settings->target_ms = arguments.target_ms;
  return Status::Ok();
}

/// Without a window nothing may depend on the clock.
Status ParseHeadless(const ViewArguments& arguments, ViewOptions* options) {
  options->headless_frames = arguments.headless_frames.value_or(0);
  options->folder = arguments.folder;
  if (arguments.headless_frames &&
      (options->headless_frames < 1 || options->headless_frames > 1'000'000)) {
    return Status::InvalidArgument(
        fmt::format("--headless-frames is {}, expected 1 to 1000000", options->headless_frames));
  }
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

void ApplySettingsFile(const SettingsFile& file, ViewSettings* settings) {
  settings->denoise = file.denoise;
  if (file.render.spp) {
    settings->auto_rate = false;
    settings->rate = ParseSampleRate(*file.render.spp).value();
  }
  if (file.render.guides) {
    settings->sparse_guides = *file.render.guides == "sparse";
  }
  if (file.render.sampler) {
    settings->sampler =
        *file.render.sampler == "sobol" ? SamplerKind::kSobol : SamplerKind::kHalton16;
  }
  settings->bounces = file.render.bounces.value_or(settings->bounces);
  settings->regularise = file.render.regularise.value_or(settings->regularise);
}

Result<ViewOptions> ParseViewArguments(const ViewArguments& arguments) {
  ViewOptions options;
  options.request = {arguments.scene, arguments.environment};
  options.threads = arguments.threads;
  options.report = arguments.report;
  ViewSettings& settings = options.settings;
  STILLRAY_RETURN_IF_ERROR(ParseSize(arguments.size, &settings));
  STILLRAY_RETURN_IF_ERROR(ParseDenoise(arguments, &options));
  STILLRAY_RETURN_IF_ERROR(ParsePanes(arguments.panes, &settings));
  STILLRAY_RETURN_IF_ERROR(ParseRate(arguments, &settings));
  if (arguments.guides && *arguments.guides != "full" && *arguments.guides != "sparse") {
    return Status::InvalidArgument(
        fmt::format("--guides is '{}', expected full or sparse", *arguments.guides));
  }
  settings.sparse_guides =
      arguments.guides ? *arguments.guides == "sparse" : settings.sparse_guides;
  if (arguments.bounces && (*arguments.bounces < 1 || *arguments.bounces > 32)) {
    return Status::InvalidArgument(
        fmt::format("--bounces is {}, expected 1 to 32", *arguments.bounces));
  }
  settings.bounces = arguments.bounces.value_or(settings.bounces);
  if (arguments.sampler && *arguments.sampler != "sobol" && *arguments.sampler != "halton16") {
    return Status::InvalidArgument(
        fmt::format("--sampler is '{}', expected sobol or halton16", *arguments.sampler));
  }
  if (arguments.sampler) {
    settings.sampler = *arguments.sampler == "sobol" ? SamplerKind::kSobol : SamplerKind::kHalton16;
  }
  if (!(arguments.fps >= kMinFps && arguments.fps <= kMaxFps)) {
    return Status::InvalidArgument(
        fmt::format("--fps is {}, expected {} to {}", arguments.fps, kMinFps, kMaxFps));
  }
  settings.fps = arguments.fps;
  if (arguments.camera < 0) {
    return Status::InvalidArgument(
        fmt::format("--camera is {}, expected 0 or more", arguments.camera));
  }
  settings.camera = arguments.camera;
  settings.playing = arguments.play;
  STILLRAY_RETURN_IF_ERROR(ParseHeadless(arguments, &options));
  return options;
}

void DeclareViewOptions(CLI::App* command, ViewArguments* a) {
  command->add_option("scene", a->scene, ".gltf, .glb or builtin:NAME")->capture_default_str();
  command->add_option("--environment", a->environment, "Environment map: .hdr or .exr");
  command->add_option("--size", a->size, "Of the window: WIDTHxHEIGHT in pixels")
      ->capture_default_str();
  command->add_option("--settings", a->settings_file,
                      "A file of name=value lines, as the viewer saves them");
  command->add_option("--preset", a->preset, "Settings of the denoiser");
  command->add_option("--set", a->set, "One setting of it: name=value")
      ->take_all()
      ->allow_extra_args(false);
  command->add_option("--views", a->panes, "What is shown side by side: noisy,denoised,reference")
      ->capture_default_str();
  command->add_option("--spp", a->spp, "Samples per pixel and frame: auto, 4, 1/8");
  command->add_option("--target-ms", a->target_ms, "Time that a frame may take, for auto")
      ->capture_default_str();
  command
      ->add_option("--scale", a->scale,
                   "Resolution of the picture: 0.05 to 1, or auto: 1 while it fits")
      ->capture_default_str();
  command
      ->add_option("--moving-filter", a->moving_filter,
                   "Filter while something moves and frames take too long: psvgf, with sparse "
                   "guides, or same: the one chosen")
      ->capture_default_str();
  command->add_option("--guides", a->guides, "Below one sample per pixel: full or sparse");
  command->add_option("--bounces", a->bounces, "Surfaces a path scatters at; default: 4");
  command->add_option("--sampler", a->sampler, "sobol or halton16");
  command->add_option("--camera", a->camera, "Number of the file's camera, from 0")
      ->capture_default_str();
  command->add_option("--fps", a->fps, "Frames per second of clips and single steps")
      ->capture_default_str();
  command->add_flag("--play", a->play, "Start the animation at once");
  AddDeviceOption(command, &a->device, &a->verbose);
  command->add_option("--threads", a->threads, "Default: all processors")
      ->check(CLI::Range(0, 4096));
  command->add_option("--headless-frames", a->headless_frames,
                      "No window: write what it would show, frame by frame, to -o");
  command->add_option("--report", a->report,
                      "At the end, write how long the window's own frames took: JSON");
  command->add_option("-o,--output", a->folder, "Folder for --headless-frames");
}

}  // namespace stillray::view
