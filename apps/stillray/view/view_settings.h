// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The settings of a view: a plain value passed from the interface to the engine.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "stillray/denoise.hpp"
#include "stillray/render.h"
#include "view/sample_rate.h"
#include "view/view_pose.h"

namespace stillray::view {

/// Counters (`seek`, `focus`, `restart`) are requests, executed once when they change.
struct ViewSettings {
  int width = 640;  ///< screen area in pixels; the image is `scale` times as large
  int height = 360;
  float scale = 1;         ///< factor of the image's width and height, 0.05..1
  bool auto_scale = true;  ///< scale may be reduced to a quarter to reach the frame time
  SampleRate rate{1, 16};
  bool auto_rate = true;  ///< samples follow the target frame time
  double target_ms = 50;
  /// During motion, if frames take too long: use `psvgf` with sparse guides instead of `denoise`
  /// with full guides. Only with `auto_rate`.
  bool fast_filter = true;
  /// In static views all samples of the history have equal weight, so that the image converges
  /// instead of keeping the noise of the history length allowed by `denoise`.
  bool still_converges = true;

  /// Settings of samples and paths. RenderSettingsFor overrides size, spp and cycle, and disables
  /// `jitter` without temporal antialiasing.
  RenderSettings render;
  Settings denoise;

  bool free_camera = false;  ///< use `pose` instead of the file's animated `camera`
  ViewPose pose;
  uint64_t pose_scene = 0;  ///< number of the opened scene that `pose` belongs to (ViewEngine)
  int camera = 0;

  bool orbiting = false;    ///< the camera circles around its orbit centre
  double orbit_speed = 20;  ///< degrees per second, counter-clockwise from above
  float orbit_radius = 0;   ///< scene units; 0: distance of the camera at the start of the orbit

  bool playing = false;
  bool wall_clock = true;  ///< animations run in real time instead of 1 / fps per frame
  double fps = 30;
  double speed = 1;                   ///< speed of all animation, -8..8
  std::optional<double> light_speed;  ///< speed of moving lights, -8..8; unset: `speed`
  uint64_t seek = 0;
  double seek_seconds = 0;

  std::vector<std::string> panes = {"denoised"};  ///< views side by side, 1 to 3: see ListViews
  std::vector<float> dividers;  ///< between panes, fractions of the width; empty: even
  bool reference = false;       ///< accumulate a converged image of static views
  bool sharp_pixels = false;    ///< images are enlarged without interpolation
  bool inspect = false;
  float inspect_x = 0;  ///< fractions of the image size, from the top left
  float inspect_y = 0;
  uint64_t focus = 0;  ///< report the depth at this position
  float focus_x = 0;
  float focus_y = 0;
  uint64_t restart = 0;  ///< discard all history
  /// Incremented when the user changes a setting and waits for its effect.
  uint64_t revision = 0;
  /// Whether the interface imports images from the device (ViewFrame::shared).
  bool shares_pictures = false;

  bool operator==(const ViewSettings&) const = default;
};

}  // namespace stillray::view
