// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The state of the interface between its frames.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "view/view_engine.h"
#include "view/view_frame.h"
#include "view/view_settings.h"
#include "view/views.h"
#include "view/window/key_press.h"

namespace stillray::view {

enum class Dialog : uint8_t {
  kNone,
  kOpenScene,
  kOpenEnvironment,
  kSavePicture,
  kRecordClip,
  kLoadSettings,
  kSaveSettings,
};

/// A short message that disappears after a time.
struct Toast {
  std::string text;
  double until = 0;  ///< seconds of the interface's clock
};

struct PoseFlight {
  ViewPose from;
  ViewPose to;
  double began = 0;
};

/// Times of recent frames, for the plot.
struct TimeHistory {
  static constexpr int kLength = 180;
  std::array<FrameCost, kLength> costs = {};
  std::array<double, kLength> shown_at = {};
  int next = 0;
  int count = 0;

  /// \param now  seconds of the interface's clock
  void Add(const FrameCost& cost, double now) {
    costs[static_cast<size_t>(next)] = cost;
    shown_at[static_cast<size_t>(next)] = now;
    next = (next + 1) % kLength;
    count = count < kLength ? count + 1 : kLength;
  }
  /// Frames per second received within the last second, or of the last two frames.
  double FramesPerSecond() const;
};

struct ViewerState {
  ViewSettings settings;
  bool changed = true;  ///< `settings` must be posted
  std::string preset = "default";
  std::vector<ViewInfo> views;  ///< views available with the current settings
  std::string parameter_error;  ///< reason why the last parameter change was rejected

  SceneInfo scene;
  SceneRequest request;  ///< the last request
  LoadState load;
  const ViewFrame* frame = nullptr;  ///< the newest frame; nullptr before the first
  /// Reason why the window cannot import images from the device; empty if it can.
  std::string unshared_because;
  bool recording = false;
  TimeHistory times;

  std::array<std::optional<ViewPose>, 9> saved_views;
  std::optional<PoseFlight> flight;
  uint64_t focus_asked = 0;  ///< pending focus request; 0: none
  /// Rotate the camera to the focus, instead of only moving the orbit centre.
  bool focus_turns = false;
  double focus_until = 0;  ///< end of the point's marking, seconds of the interface's clock

  Dialog dialog = Dialog::kNone;
  bool dialog_opening = false;
  std::string dialog_path;
  std::string dialog_error;
  std::string overwrite_path;       ///< path of the file in the overwrite question
  std::vector<std::string> errors;  ///< messages of the message box, oldest first
  std::vector<Toast> toasts;

  bool show_panel = true;
  bool show_help = false;
  bool fullscreen = false;
  bool inspector_pinned = false;
  int dragged_divider = -1;
  std::vector<KeyPress> keys;  ///< keys pressed since the last interface frame
  bool quit = false;
};

/// Shows these views, e.g. from a menu.
void SetPanes(std::vector<std::string> panes, ViewerState* state);
/// Applies a preset to all parameters except exposure and tone curve, which the viewer controls.
void SetPreset(const std::string& name, ViewerState* state);
void NextPreset(ViewerState* state);
/// Switches to the free camera if necessary, and moves it to `pose`. Ends an orbit.
void SetPose(const ViewPose& pose, ViewerState* state);
/// Starts or ends an orbit at the current camera position.
void SetOrbit(bool orbits, ViewerState* state);
void UseFileCamera(int camera, ViewerState* state);
void SaveView(size_t slot, ViewerState* state);
/// Flies to the saved view; no effect if there is none.
void GoToSavedView(size_t slot, ViewerState* state);
void Seek(double seconds, ViewerState* state);
void StepFrames(int frames, ViewerState* state);
void AddToast(const std::string& text, double now, ViewerState* state);
void AddError(const std::string& text, ViewerState* state);
/// Switches from shared images to copies.
void StopSharing(const std::string& why, ViewerState* state);
/// Applies the engine's results and messages.
void Update(double now, ViewEngine* engine, ViewerState* state);

}  // namespace stillray::view
