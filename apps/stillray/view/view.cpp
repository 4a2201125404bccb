// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// stillray view: renders and denoises a scene interactively.
#include <algorithm>
#include <memory>

#include <fmt/format.h>
#include <tbb/global_control.h>
#include <tbb/info.h>
#include <CLI/CLI.hpp>

#include "common/commands.h"
#include "common/device_option.h"
#include "view/headless.h"
#include "view/view_options.h"
#include "view/window/viewer.h"

namespace stillray {
namespace {

constexpr const char* kExamples = R"(
Drag with the left mouse button to orbit, with the right one to look around; W A S D fly; F1 lists
all keys. Samples per pixel follow the time that a frame may take.

Examples:
  stillray view builtin:lights
  stillray view kitchen.glb --views noisy,denoised --target-ms 33
  stillray view scene.glb --environment sky.hdr --preset svgf
  stillray view scene.glb --orbit 15 --orbit-radius 4
  stillray view builtin:cornell --headless-frames 20 --spp 1/8 -o out    no window: pictures)";

Status RunView(const view::ViewArguments& arguments) {
  Result<view::ViewOptions> options = view::ParseViewArguments(arguments);
  if (!options.ok()) {
    return options.status();
  }
  const int threads = options->threads > 0
                          ? std::min(options->threads, tbb::info::default_concurrency())
                          : tbb::info::default_concurrency();
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                  static_cast<size_t>(threads));
  const Result<RenderDevices> devices =
      OpenRenderDevices(arguments.device, arguments.trace_device, arguments.verbose);
  STILLRAY_RETURN_IF_ERROR(devices.status());
  options->devices = *devices;
  if (options->headless_frames > 0) {
    return view::RunHeadless(options.value());
  }
  return view::RunViewer(options.value());
}

}  // namespace

void AddViewCommand(CLI::App& app, int* exit_code) {
  CLI::App* command = app.add_subcommand("view", "Show a scene live");
  auto arguments = std::make_shared<view::ViewArguments>();
  view::DeclareViewOptions(command, arguments.get());
  command->footer(kExamples);
  command->callback([arguments, exit_code] {
    const Status status = RunView(*arguments);
    *exit_code = status.ok() ? kExitOk : ReportError(status);
  });
}

}  // namespace stillray
