// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// stillray render: renders and denoises a scene.
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <tbb/global_control.h>
#include <tbb/info.h>
#include <CLI/CLI.hpp>

#include "common/commands.h"
#include "common/console.h"
#include "common/device_option.h"
#include "common/interrupt.h"
#include "common/option_checks.h"
#include "io/frame_rate.h"
#include "render/render_options.h"
#include "render/render_run.h"
#include "stillray/io.h"
#include "stillray/scene.h"

namespace stillray {
namespace {

Result<Scene> LoadSceneFor(const RenderOptions& options) {
  Result<Scene> scene = LoadScene(options.text.scene, [] { return !Interrupted(); });
  if (scene.ok() && !options.text.lens_mask.empty()) {
    const Status set = SetLensMask(options.text.lens_mask, &scene.value());
    if (!set.ok()) {
      return Status(set.code(), "--lens-mask: " + set.message());
    }
  }
  if (!scene.ok() || options.text.environment.empty()) {
    return scene;
  }
  bool linear = false;
  Result<Image3> map = ReadImage(options.text.environment, &linear);
  if (!map.ok()) {
    return Status(map.status().code(), "--environment: " + map.status().message());
  }
  if (!linear) {
    return Status::InvalidArgument(
        fmt::format("--environment {} is a display picture, expected radiance as .hdr or .exr",
                    options.text.environment));
  }
  scene->environment.map = std::move(map.value());
  scene->environment.radiance = vec3(1.0f);
  return scene;
}

Status RunRender(const RenderArguments& arguments) {
  Result<RenderOptions> options = ParseRenderArguments(arguments);
  if (!options.ok()) {
    return options.status();
  }
  const int available = tbb::info::default_concurrency();
  const int threads = arguments.threads > 0 ? arguments.threads : available;
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                  static_cast<size_t>(threads));
  SetExrThreads(threads > 1 ? threads : 0);
  CatchInterrupts();
  const Result<Scene> scene = LoadSceneFor(*options);
  if (scene.status().code() == StatusCode::kCancelled) {
    return Status(StatusCode::kCancelled, "stopped while the scene was loaded");
  }
  if (!scene.ok()) {
    return scene.status();
  }
  for (const std::string& warning : scene->warnings) {
    PrintTo(stderr, "warning: {}\n", warning);
  }
  return RunFrames(*options, *scene, threads);
}

/// All built-in scenes except for `scene`.
std::string OtherScenes(const std::string& scene) {
  std::vector<std::string> others;
  for (const std::string& name : BuiltinSceneNames()) {
    if ("builtin:" + name != scene) {
      others.push_back("builtin:" + name);
    }
  }
  return fmt::format("{}", fmt::join(others, ", "));
}

constexpr const char* kExamples = R"(
Frame N shows the animation at (N - 1) / fps seconds. DIR gets denoised.####.exr/png/jpg, with
--save-inputs noisy.####.exr/png/jpg, with --reference reference.####.exr/png/jpg, denoised.mp4 and
render.json.

Examples:
  stillray render
  stillray render builtin:cornell -o out
  stillray render kitchen.glb -o out --size 1920x1080 --frames 1-60 --spp 2 --format exr
  stillray render builtin:lights -o out --preset svgf --set sigma_l=6 --aov temporal,variance
  stillray render scene.gltf -o out --environment sky.hdr --exposure 1 --tonemap filmic
  stillray render builtin:spheres -o out --frames 1-32 --reference 1024 --reference-frames 31-32
  stillray render builtin:cornell -o out --still --spp 1/16 --guides sparse
  stillray render scene.glb -o out --save-inputs --format exr
  stillray render builtin:spheres -o out --post dof,motion_blur --aperture 0.05 --shutter 0.5
  stillray render kitchen.glb -o out --still --frames 1-200 --format png --resume
)";

}  // namespace

void AddRenderCommand(CLI::App& app, int* exit_code) {
  CLI::App* command = app.add_subcommand(
      "render", "Path-trace a scene at few samples per pixel and denoise every frame");
  command->footer(kExamples);
  const auto a = std::make_shared<RenderArguments>();
  CLI::Option* scene =
      command
          ->add_option("scene", a->scene,
                       ".gltf, .glb, .obj or builtin:NAME (cornell, spheres, lights, mirrors, "
                       "materials, thin, faust, colonnade, car)")
          ->capture_default_str();
  command->option_defaults()->group("Output");
  command->add_option("-o,--output", a->folder, "Folder for the pictures; made if needed")
      ->capture_default_str();
  command->add_option("--size", a->size, "WIDTHxHEIGHT in pixels")->capture_default_str();
  command->option_defaults()->group("Scene");
  command->add_option("--frames", a->frames, "FIRST-LAST, or one frame")->capture_default_str();
  command->add_option("--fps", a->fps, "Frames per second")
      ->check(InRange(kMinFps, kMaxFps))
      ->capture_default_str();
  command->add_flag("--still", a->still,
                    "Freeze scene and camera at the first frame, with new noise in every frame");
  command->add_option("--camera", a->camera, "Name or number of the camera; default: the first");
  command->add_option("--environment", a->environment,
                      "Environment map: .hdr or .exr, latitude-longitude");
  command->option_defaults()->group("Sampling");
  AddTracerOptions(command, &a->tracer);
  command
      ->add_option("--lens-mask", a->lens_mask,
                   "Picture of the aperture (.png, .jpg, .webp): light passes where it is bright")
      ->excludes("--blades");
  command
      ->add_option(
          "--reference", a->reference_spp,
          "Also render converged pictures with this many paths per pixel, of Sobol' points "
          "with any --sampler")
      ->check(InRange(1, 1 << 20));
  command->add_option("--reference-frames", a->reference_frames,
                      "Only for these frames, such as 30-31,60-61; default: all");
  command->option_defaults()->group("Denoiser");
  AddFilterOptions(command, &a->filter);
  command->get_option("--settings")->excludes("--preset");
  command->option_defaults()->group("Output");
  AddDisplayOptions(command, &a->display);
  AddPostOptions(command, &a->post);
  command
      ->add_option(
          "--aov", a->aovs,
          "More layers and pictures: guides (normal, depth, ...), and outputs of the filter "
          "(temporal, atrousN, weightsN, variance, smoothed_variance, alpha, history, ...; "
          "an unknown name lists all)")
      ->allow_extra_args(false)
      ->take_all();
  CLI::Option* format =
      command->add_option("--format", a->formats, "Formats to write: a list of exr, png, jpg, mp4")
          ->capture_default_str();
  command->add_flag("--save-inputs", a->save_inputs,
                    "Also write the noisy frames: EXR files with every signal and every guide, as "
                    "`stillray denoise` reads them, and PNG files");
  command->add_flag("--float", a->float_exr, "32-bit EXR files; default: 16-bit (half)");
  command->option_defaults()->group("Device");
  AddDeviceOption(command, &a->device, &a->verbose);
  AddTraceDeviceOption(command, &a->trace_device);
  command
      ->add_option("--ray-tracing", a->ray_tracing,
                   "How a Vulkan device traces rays: hardware, compute (shaders), or auto: "
                   "hardware if a GPU supports it")
      ->check(OneOf({"auto", "hardware", "compute"}))
      ->capture_default_str();
  command
      ->add_option(
          "--first-hits", a->first_hits,
          "How a Vulkan device finds what the camera sees: draw (the rasteriser), trace, or "
          "auto: draw, except where the driver emulates ray tracing")
      ->check(OneOf({"auto", "draw", "trace"}))
      ->capture_default_str();
  command
      ->add_option("--textures", a->textures,
                   "How a Vulkan device reads textures: sampled (by its texture units, to 1/256 of "
                   "a texel), exact (as the CPU), or auto: sampled by GPUs")
      ->check(OneOf({"auto", "exact", "sampled"}))
      ->capture_default_str();
  command->add_option("--threads", a->threads, "Default: all processors")
      ->check(CLI::Range(0, 4096));
  command->option_defaults()->group("Output");
  command->add_flag("--resume", a->resume, "Resume an interrupted run with the same settings");
  command->add_flag("--timings", a->timings, "Print milliseconds per stage, and memory");
  command->add_option("--json", a->json_path,
                      "Write settings, times and memory there too (- for standard output)");
  command->callback([a, scene, format, exit_code] {
    a->formats_given = format->count() > 0;
    if (scene->count() == 0) {
      PrintTo(stderr,
              "no scene is named: rendering {}; others: {}, or a .gltf, .glb or .obj file\n",
              a->scene, OtherScenes(a->scene));
    }
    const Status status = RunRender(*a);
    *exit_code = status.ok() ? kExitOk : ReportError(status);
  });
}

}  // namespace stillray
