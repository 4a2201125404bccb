// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The command line of `stillray view`, checked before any work starts.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/filter_options.h"
#include "common/render_devices.h"
#include "common/tracer_options.h"
#include "view/loaded_scene.h"
#include "view/view_settings.h"

namespace CLI {
class App;
}

namespace stillray::view {

/// The options as text.
struct ViewArguments {
  std::string scene = "builtin:cornell";
  std::string environment;
  std::string size = "1280x720";
  FilterArguments filter;
  TracerArguments tracer;
  std::string scale = "auto";
  std::string panes = "denoised";
  double target_ms = 50;
  double fps = 30;
  int camera = 0;
  bool play = false;
  std::optional<double> orbit;
  float orbit_radius = 0;
  int threads = 0;
  std::optional<int> headless_frames;
  std::string folder;
  std::string report;
  std::string moving_filter = "psvgf";
  std::string still_history = "all";
  std::string device = "auto";
  std::string trace_device;  ///< empty: `device`
  bool verbose = false;
};

/// The parsed options.
struct ViewOptions {
  SceneRequest request;
  ViewSettings settings;  ///< `width` and `height` are the size of the window, or of the images
                          ///< without a window
  std::string preset;
  int threads = 0;
  int headless_frames = 0;  ///< 0: open a window
  std::string folder;
  std::string report;     ///< file for the times of the interface; empty: none
  RenderDevices devices;  ///< opened by the caller of ParseViewArguments
};

/// Applies the file's values; other settings are unchanged.
/// \return kInvalidArgument if a path tracer setting is invalid; all settings are then unchanged
Status ApplySettingsFile(const SettingsFile& file, ViewSettings* settings);

/// \return kInvalidArgument naming the option, its value and the expected ones
Result<ViewOptions> ParseViewArguments(const ViewArguments& arguments);

void DeclareViewOptions(CLI::App* command, ViewArguments* arguments);

}  // namespace stillray::view
