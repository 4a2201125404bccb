// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// stillray denoise: reads frames of any renderer, and writes the files with denoised radiance.
#include <memory>
#include <string>

#include <tbb/global_control.h>
#include <tbb/info.h>
#include <CLI/CLI.hpp>

#include "common/commands.h"
#include "common/device_option.h"
#include "common/interrupt.h"
#include "common/option_checks.h"
#include "common/sequence_options.h"
#include "denoise/denoise_options.h"
#include "denoise/denoise_run.h"
#include "io/frame_rate.h"

namespace stillray {
namespace {

Status ParseAndRun(const DenoiseArguments& arguments) {
  Result<DenoiseOptions> options = ParseDenoiseArguments(arguments);
  if (!options.ok()) {
    return options.status();
  }
  const int threads = arguments.threads > 0 ? arguments.threads : tbb::info::default_concurrency();
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                  static_cast<size_t>(threads));
  SetExrThreads(threads > 1 ? threads : 0);
  CatchInterrupts();
  return RunDenoise(*options, threads);
}

constexpr const char* kExamples = R"(
Writes a copy of every file with clean light in place of its colour (Blender: Combined; it is added
if a file has none). All other layers (light layers too, without --passes), the metadata and the
compression are unchanged.
docs/renderers.md lists known layer names, and how to map others.

Examples:
  stillray denoise 'shot.####.exr' -o clean
  stillray denoise 'shot.####.exr' -o clean --preview clean/preview.mp4
  stillray denoise 'shot.%04d.exr' -o 'clean/shot.####.exr' --frames 1-24 --renderer blender
  stillray denoise frames/ -o clean/ --aov normal=N,encoded --aov motion=mv,ndc,from_previous,y_up
  stillray denoise a.0001.exr a.0002.exr -o clean/ --timings --json log.json
  stillray denoise 'shot.*.exr' -o clean/ --window past --passes --preview 'look/####.png'
  stillray denoise 'smoke.####.exr' -o clean --alpha denoise
  stillray denoise 'shot.####.exr' -o clean --resume
  stillray denoise 'blurred.####.exr' -o clean --cameras cameras.json
  stillray denoise 'shot.####.exr' -o clean --motion estimate
  stillray denoise 'shot.####.exr' -o clean --post dof,motion_blur --aperture f/2.8 --fov 40
)";

}  // namespace

void AddDenoiseCommand(CLI::App& app, int* exit_code) {
  CLI::App* command = app.add_subcommand(
      "denoise", "Denoise a sequence of EXR files of Blender, Arnold or another renderer");
  command->footer(kExamples);
  const auto a = std::make_shared<DenoiseArguments>();
  command
      ->add_option("-o,--output", a->output,
                   "EXR files: a pattern (out.####.exr), or a folder; made if needed")
      ->required();
  AddSequenceOptions(command, &a->inputs, &a->frames, &a->aovs);
  AddFilterOptions(command, &a->filter);
  command->get_option("--settings")->excludes("--preset");
  CLI::Option* set = command->get_option("--set");
  set->description(set->get_description() +
                   ". antialias is off unless it is set here, the frames are jittered, or "
                   "their guides are antialiased (docs/renderers.md)");
  command
      ->add_option(
          "--window", a->window,
          "past: a frame gets the light of frames before it; both: of frames after it too, "
          "so that first frames and what comes into view are as clean as the rest. both takes "
          "about half as long again and 1.8 kB per pixel more memory, or less memory and "
          "more time with the same result where --memory-limit demands it; auto: both, and past "
          "for one frame, where frames are missing, and where memory is too little for both")
      ->check(OneOf({"auto", "past", "both"}))
      ->capture_default_str();
  command
      ->add_option(
          "--motion", a->motion,
          "Motion towards the previous frame. file: of the motion layer; camera: of still "
          "surfaces, "
          "from depth and the cameras (in the files, or --cameras); estimate: found in the guides, "
          "beginning with the cameras where they are known; auto: file, and where the files have "
          "no "
          "motion, or zeros although guides move (Blender with motion blur), camera and estimate")
      ->check(OneOf({"auto", "file", "camera", "estimate"}))
      ->capture_default_str();
  command->add_option("--cameras", a->cameras,
                      "JSON file with the camera of every frame (docs/files.md), in place of "
                      "worldToCamera and worldToNDC in the files");
  command
      ->add_option("--spp", a->spp,
                   "Samples per pixel, of files that do not state them; default: as Cycles and "
                   "stillray state them, else 1")
      ->check(CLI::Range(1, 1 << 20));
  command->add_flag(
      "--passes", a->passes,
      "Write the denoised light of every light layer (DiffDir, GlossInd, ...) too, so "
      "that putting the layers together gives the denoised colour");
  command
      ->add_option("--alpha", a->alpha,
                   "keep: alpha is copied; denoise: it is filtered as the light is (smoke, hair, "
                   "blurred edges)")
      ->check(OneOf({"keep", "denoise"}))
      ->capture_default_str();
  command->add_option("--preview", a->preview,
                      "Write display pictures too: a video (look.mp4), or PNG files "
                      "('look/####.png', or a folder)");
  AddDisplayOptions(command, &a->display);
  AddPostOptions(command, &a->post);
  command->add_option("--aperture", a->aperture,
                      "With --post dof: radius of the lens in the unit of depth, or f/N if that is "
                      "metres");
  command->add_option("--focus", a->focus,
                      "With --post dof: depth that is sharp, or auto: that of the picture's centre "
                      "(the default)");
  command
      ->add_option(
          "--fov", a->fov,
          "With --post dof: vertical angle of view in degrees; default: of the cameras, if "
          "the files or --cameras have them")
      ->check(InRange(0.1, 179));
  CLI::Option* fps = command->add_option("--fps", a->fps, "Frames per second of the video")
                         ->check(InRange(kMinFps, kMaxFps))
                         ->capture_default_str();
  command->add_flag("--no-check", a->no_check,
                    "Skip the check of the first frames (stillray check examines all)");
  AddDeviceOption(command, &a->device, &a->verbose);
  command->add_option("--threads", a->threads, "Default: all processors")
      ->check(CLI::Range(0, 4096));
  command->add_option(
      "--memory-limit", a->memory_limit,
      "Reject frames that need more memory, such as 8G; default: the machine's memory");
  command->add_flag("--resume", a->resume, "Resume an interrupted run with the same settings");
  command->add_flag("--timings", a->timings, "Print milliseconds per stage, and memory");
  command->add_option(
      "--json", a->json_path,
      "Write settings, times and the roles of layers there (- for standard output)");
  command->callback([a, fps, exit_code] {
    a->fps_given = fps->count() > 0;
    const Status status = ParseAndRun(*a);
    *exit_code = status.ok() ? kExitOk : ReportError(status);
  });
}

}  // namespace stillray
