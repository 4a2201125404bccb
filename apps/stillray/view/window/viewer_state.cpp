// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "view/window/viewer_state.h"

#include <algorithm>

#include <fmt/format.h>

namespace stillray::view {
namespace {

constexpr double kToastSeconds = 4;
constexpr size_t kMostErrors = 5;
constexpr double kFlightSeconds = 0.6;
constexpr double kMarkSeconds = 1.5;

void TakeMessages(double now, ViewEngine* engine, ViewerState* state) {
  for (const EngineMessage& message : engine->TakeMessages()) {
    if (message.is_error) {
      AddError(message.text, state);
    } else {
      AddToast(message.text, now, state);
    }
  }
}

void TakeScene(double now, ViewEngine* engine, ViewerState* state) {
  SceneInfo info = engine->scene_info();
  if (info.number == state->scene.number) {
    return;
  }
  // The camera of the command line applies only to the scene of the command line.
  int camera = state->scene.number == 0 ? state->settings.camera : 0;
  if (static_cast<size_t>(camera) >= info.cameras.size()) {
    AddError(fmt::format("--camera is {}, the scene's are numbered 0 to {}", camera,
                         info.cameras.size() - 1),
             state);
    camera = 0;
  }
  state->scene = std::move(info);
  if (state->scene.number == 1) {
    AddToast("Drag to orbit, wheel to come nearer, Tab to compare, F1 for all keys", now + 4,
             state);
  }
  for (const std::string& warning : state->scene.warnings) {
    AddToast(warning, now, state);
  }
  state->saved_views = {};
  state->flight.reset();
  UseFileCamera(camera, state);
}

/// Sets the orbit centre, once the depth at the clicked pixel is known.
void Focus(double now, const ViewFrame& frame, ViewerState* state) {
  state->focus_asked = 0;
  const ViewSettings& s = state->settings;
  const float aspect = static_cast<float>(frame.width) / static_cast<float>(frame.height);
  if (state->focus_turns) {
    const ViewPose target = FocusOn(frame.pose, s.focus_x, s.focus_y, aspect, frame.focus_depth);
    if (!(target == frame.pose)) {
      state->flight = PoseFlight{frame.pose, target, -1};
    }
    return;
  }
  const ViewPose around = OrbitAround(frame.pose, s.focus_x, s.focus_y, aspect, frame.focus_depth);
  if (!(around == frame.pose)) {
    // The camera may have moved since the request.
    ViewPose pose = s.free_camera ? s.pose : frame.pose;
    pose.distance = around.distance;
    pose.aside = around.aside;
    SetPose(pose, state);
    state->focus_until = now + kMarkSeconds;
  }
}

void TakeFrame(double now, ViewEngine* engine, ViewerState* state) {
  const ViewFrame* frame = engine->TakeFrame();
  if (frame == nullptr) {
    return;
  }
  state->frame = frame;
  state->times.Add(frame->cost, now);
  if (state->focus_asked != 0 && frame->focus == state->focus_asked) {
    Focus(now, *frame, state);
  }
}

void Fly(double now, ViewerState* state) {
  if (!state->flight) {
    return;
  }
  PoseFlight& flight = *state->flight;
  flight.began = flight.began < 0 ? now : flight.began;
  const double t = std::min((now - flight.began) / kFlightSeconds, 1.0);
  const ViewPose pose = Between(flight.from, flight.to, static_cast<float>(t * t * (3 - 2 * t)));
  if (t >= 1) {
    const ViewPose end = flight.to;
    state->flight.reset();
    SetPose(end, state);
  } else {
    const PoseFlight kept = flight;
    SetPose(pose, state);  // other changes of the pose end the flight
    state->flight = kept;
  }
}

}  // namespace

double TimeHistory::FramesPerSecond() const {
  const auto at = [&](int back) {
    return shown_at[static_cast<size_t>((next - 1 - back + 2 * kLength) % kLength)];
  };
  int frames = 0;
  while (frames + 1 < count && (frames == 0 || at(0) - at(frames) < 1)) {
    ++frames;
  }
  const double seconds = frames > 0 ? at(0) - at(frames) : 0;
  return seconds > 0 ? frames / seconds : 0;
}

void SetPanes(std::vector<std::string> panes, ViewerState* state) {
  if (panes.size() != state->settings.panes.size()) {
    state->settings.dividers.clear();
  }
  state->settings.panes = std::move(panes);
  const std::vector<std::string>& now = state->settings.panes;
  if (std::find(now.begin(), now.end(), "reference") != now.end()) {
    state->settings.reference = true;
  }
  state->changed = true;
}

void SetPreset(const std::string& name, ViewerState* state) {
  Result<Settings> preset = PresetSettings(name);
  if (!preset.ok()) {
    AddError(preset.status().message(), state);
    return;
  }
  preset->exposure = state->settings.denoise.exposure;
  preset->tonemap = state->settings.denoise.tonemap;
  state->settings.denoise = preset.value();
  state->preset = name;
  state->parameter_error.clear();
  state->changed = true;
}

void NextPreset(ViewerState* state) {
  const std::span<const std::string_view> names = PresetNames();
  const auto found = std::find(names.begin(), names.end(), state->preset);
  const auto next = found == names.end() || found + 1 == names.end() ? names.begin() : found + 1;
  SetPreset(std::string(*next), state);
}

void SetPose(const ViewPose& pose, ViewerState* state) {
  state->flight.reset();
  state->settings.free_camera = true;
  state->settings.orbiting = false;
  state->settings.pose = pose;
  state->settings.pose_scene = state->scene.number;
  state->changed = true;
}

void SetOrbit(bool orbits, ViewerState* state) {
  if (state->frame != nullptr && orbits != state->settings.orbiting) {
    SetPose(state->frame->pose, state);
    state->settings.orbiting = orbits;
  }
}

void UseFileCamera(int camera, ViewerState* state) {
  state->flight.reset();
  state->settings.free_camera = false;
  state->settings.camera = camera;
  state->changed = true;
}

void SaveView(size_t slot, ViewerState* state) {
  if (state->frame != nullptr) {
    state->saved_views[slot] = state->frame->pose;
  }
}

void GoToSavedView(size_t slot, ViewerState* state) {
  if (state->frame != nullptr && state->saved_views[slot]) {
    state->flight = PoseFlight{state->frame->pose, *state->saved_views[slot], -1};
  }
}

void Seek(double seconds, ViewerState* state) {
  ++state->settings.seek;
  state->settings.seek_seconds = seconds;
  state->changed = true;
}

void StepFrames(int frames, ViewerState* state) {
  if (state->frame == nullptr) {
    return;
  }
  state->settings.playing = false;
  Seek(state->frame->seconds + frames / state->settings.fps, state);
}

void AddToast(const std::string& text, double now, ViewerState* state) {
  state->toasts.push_back({text, now + kToastSeconds});
}

void AddError(const std::string& text, ViewerState* state) {
  const bool known =
      std::find(state->errors.begin(), state->errors.end(), text) != state->errors.end();
  if (!known && state->errors.size() < kMostErrors) {
    state->errors.push_back(text);
  }
}

void StopSharing(const std::string& why, ViewerState* state) {
  state->unshared_because = why;
  state->settings.shares_pictures = false;
  state->changed = true;
}

void Update(double now, ViewEngine* engine, ViewerState* state) {
  TakeMessages(now, engine, state);
  TakeScene(now, engine, state);
  TakeFrame(now, engine, state);
  Fly(now, state);
  state->load = engine->load_state();
  state->recording = engine->recording();
  state->views = ListViews(state->settings.denoise);
  std::erase_if(state->toasts, [now](const Toast& toast) { return toast.until < now; });
}

}  // namespace stillray::view
