// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// What the interface knows and remembers from one of its frames to the next.
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

/// Short notice that goes away by itself.
struct Toast {
  std::string text;
  double until = 0;  ///< seconds of the interface's clock
};

struct PoseFlight {
  ViewPose from;
  ViewPose to;
  double began = 0;
};

/// Times of the last frames, for the plot.
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
  /// Frames per second that came to the window within the last second, or the last two frames.
  double FramesPerSecond() const;
};

struct ViewerState {
  ViewSettings settings;
  bool changed = true;  ///< `settings` is to be posted
  std::string preset = "default";
  std::vector<ViewInfo> views;  ///< for the present settings
  std::string parameter_error;  ///< why the last change of a parameter was refused

  SceneInfo scene;
  SceneRequest request;  ///< last asked for
  LoadState load;
  const ViewFrame* frame = nullptr;  ///< newest; nullptr before the first
  /// Why the window cannot take pictures from the device; empty: it can.
  std::string unshared_because;
  bool recording = false;
  TimeHistory times;

  std::array<std::optional<ViewPose>, 9> saved_views;
  std::optional<PoseFlight> flight;
  uint64_t focus_asked = 0;  ///< order to focus that waits for its answer; 0: none
  bool focus_turns = false;  ///< the camera turns there; else it will only orbit around it
  double focus_until = 0;    ///< the point is marked until then, seconds of the interface's clock

  Dialog dialog = Dialog::kNone;
  bool dialog_opening = false;
  std::string dialog_path;
  std::string dialog_error;
  std::string overwrite_path;       ///< the user has been asked whether to overwrite this file
  std::vector<std::string> errors;  ///< to be shown in a message box, oldest first
  std::vector<Toast> toasts;

  bool show_panel = true;
  bool show_help = false;
  bool fullscreen = false;
  bool inspector_pinned = false;
  int dragged_divider = -1;
  std::vector<KeyPress> keys;  ///< that went down since the last frame of the interface
  bool quit = false;
};

/// The widget row of one choice of views, e.g. in a menu.
void SetPanes(std::vector<std::string> panes, ViewerState* state);
/// Takes a preset's values for all parameters but exposure and tone curve, which are the viewer's.
void SetPreset(const std::string& name, ViewerState* state);
void NextPreset(ViewerState* state);
/// The camera leaves the file's path, if it has not yet, and stands at `pose`.
void SetPose(const ViewPose& pose, ViewerState* state);
void UseFileCamera(int camera, ViewerState* state);
void SaveView(size_t slot, ViewerState* state);
/// Flies there; nothing happens if nothing was saved.
void GoToSavedView(size_t slot, ViewerState* state);
void Seek(double seconds, ViewerState* state);
void StepFrames(int frames, ViewerState* state);
void AddToast(const std::string& text, double now, ViewerState* state);
void AddError(const std::string& text, ViewerState* state);
/// From now on pictures come as copies.
void StopSharing(const std::string& why, ViewerState* state);
/// Takes what the engine has to tell.
void Update(double now, ViewEngine* engine, ViewerState* state);

}  // namespace stillray::view
