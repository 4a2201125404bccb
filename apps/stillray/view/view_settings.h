// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The settings of a picture: one plain value that the interface passes to the engine.
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
  int width = 640;  ///< of the area on the screen, pixels; the picture is `scale` times as large
  int height = 360;
  float scale = 1;         ///< of the picture's width and height, 0.05..1
  bool auto_scale = true;  ///< may fall to a quarter of that to reach the frame time
  SampleRate rate{1, 16};
  bool auto_rate = true;  ///< samples follow the target frame time
  double target_ms = 50;
  /// While something moves and frames take too long: use `psvgf` and sparse guides instead of
  /// `denoise` and full ones. Only with `auto_rate`.
  bool fast_filter = true;
  /// Once nothing moves: all samples of the history have equal weight, so that the picture
  /// converges instead of keeping the noise of the shortest histories that `denoise` allows.
  bool still_converges = true;

  /// Of samples and paths. Size, spp and cycle are those of RenderSettingsFor, which also switches
  /// `jitter` off without antialiasing in time.
  RenderSettings render;
  Settings denoise;

  bool free_camera = false;  ///< use `pose`; else the file's `camera`, with its animation
  ViewPose pose;
  uint64_t pose_scene = 0;  ///< number of the opened scene that `pose` belongs to (ViewEngine)
  int camera = 0;

  bool orbiting = false;    ///< the camera circles around its orbit centre
  double orbit_speed = 20;  ///< degrees per second, counter-clockwise from above
  float orbit_radius = 0;   ///< scene units; 0: the camera's distance when it began

  bool playing = false;
  bool wall_clock = true;  ///< animations run in real time; else by 1 / fps per frame
  double fps = 30;
  double speed = 1;                   ///< of all animation, -8..8
  std::optional<double> light_speed;  ///< of moving lights, -8..8; none: as `speed`
  uint64_t seek = 0;
  double seek_seconds = 0;

  std::vector<std::string> panes = {"denoised"};  ///< views side by side, 1 to 3: see ListViews
  std::vector<float> dividers;  ///< between panes, fractions of the width; empty: even
  bool reference = false;       ///< accumulate a converged picture while nothing moves
  bool sharp_pixels = false;    ///< pictures are enlarged without interpolation
  bool inspect = false;
  float inspect_x = 0;  ///< fractions of the picture, from the top left
  float inspect_y = 0;
  uint64_t focus = 0;  ///< report the depth at this position
  float focus_x = 0;
  float focus_y = 0;
  uint64_t restart = 0;  ///< discard all history
  /// Increases when the user has changed a setting and waits for its effect.
  uint64_t revision = 0;
  /// The interface imports pictures from the device (ViewFrame::shared).
  bool shares_pictures = false;

  bool operator==(const ViewSettings&) const = default;
};

}  // namespace stillray::view
