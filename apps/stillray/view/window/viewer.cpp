// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "view/window/viewer.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <thread>

#include <fmt/format.h>
#include <imgui.h>

#include "common/interrupt.h"
#include "core/clock.h"
#include "view/view_engine.h"
#include "view/window/camera_input.h"
#include "view/window/gl_window.h"
#include "view/window/interface_times.h"
#include "view/window/layout.h"
#include "view/window/pane_textures.h"
#include "view/window/panels.h"
#include "view/window/picture_area.h"
#include "view/window/viewer_state.h"

namespace stillray::view {
namespace {

/// Wake-up intervals for changes other than input and new images, which wake the interface.
constexpr double kIdleSeconds = 0.5;
constexpr double kLivelySeconds = 0.016;
constexpr double kShortestFrame = 0.012;  // limit if the display does not limit the frame rate
/// Number of frames over which widgets respond to input.
constexpr int kFramesAfterInput = 3;

std::string Title(const SceneRequest& request) {
  return std::filesystem::path(request.scene).filename().string() + " - stillray";
}

/// Draws one frame of the interface. \return whether it contains its own animation
bool DrawInterface(double now, double elapsed, PaneTextures* textures, ViewEngine* engine,
                   ViewerState* state) {
  DrawMenu(engine, state);
  const ImGuiIO& io = ImGui::GetIO();
  const Layout layout =
      MakeLayout(io.DisplaySize.x, io.DisplaySize.y, ImGui::GetFrameHeight(),
                 ImGui::GetFrameHeight(), ImGui::GetFontSize(), state->show_panel);
  const int width = static_cast<int>(layout.picture.width);
  const int height = static_cast<int>(layout.picture.height);
  if (width != state->settings.width || height != state->settings.height) {
    state->settings.width = width;
    state->settings.height = height;
    state->changed = true;
  }
  if (state->frame != nullptr) {
    const Status uploaded = textures->Upload(*state->frame, state->settings.sharp_pixels);
    if (!uploaded.ok()) {
      StopSharing(uploaded.message(), state);
    }
  }
  DrawPictureArea(layout.picture, *textures, now, state);
  DrawPlaybackBar(layout.bar, state);
  if (state->show_panel) {
    DrawSidePanel(layout.panel, state);
  }
  DrawDialogs(engine, state);
  HandleKeys(engine, state);
  const bool flying = HandleFlyKeys(elapsed, state);
  return flying || state->flight || state->load.loading || state->dragged_divider >= 0;
}

/// Runs one frame of the interface, from input to the screen.
void DrawFrame(double now, double elapsed, bool* lively, GlWindow* window, PaneTextures* textures,
               InterfaceTimes* times, ViewEngine* engine, ViewerState* state) {
  window->BeginFrame();
  *lively = DrawInterface(now, elapsed, textures, engine, state);
  if (state->changed) {
    const uint64_t made = engine->frames_made();
    times->Posted(engine->Post(state->settings), made, now);
    state->changed = false;
  }
  window->EndFrame();
  const double end = SecondsNow();
  times->Drawn((end - now) * 1e3);
  if (state->frame != nullptr) {
    times->Shown(*state->frame, end);
  }
}

/// \param watch  process events frequently even without drawing, to measure gaps
InterfaceTimes Loop(bool watch, GlWindow* window, std::atomic<bool>* news, ViewEngine* engine,
                    ViewerState* state) {
  PaneTextures textures;
  const Status shares = textures.PrepareSharing();
  state->settings.shares_pictures = shares.ok();
  state->unshared_because = shares.message();
  double last = SecondsNow();
  bool lively = true;
  int frames_due = kFramesAfterInput;
  uint64_t titled = 0;
  InterfaceTimes times;
  while (!window->should_close() && !state->quit && !Interrupted()) {
    const bool soon = lively || frames_due > 0;
    const double patience = soon || watch ? kLivelySeconds : kIdleSeconds;
    frames_due = window->WaitForEvents(patience) ? kFramesAfterInput : frames_due;
    double now = SecondsNow();
    times.Looked(now);
    if (!soon && frames_due == 0 && !*news && now - last < kIdleSeconds) {
      continue;
    }
    if (now - last < kShortestFrame) {
      std::this_thread::sleep_for(std::chrono::duration<double>(kShortestFrame - (now - last)));
      now = SecondsNow();
    }
    *news = false;
    Update(now, engine, state);
    for (const std::string& path : window->TakeDroppedFiles()) {
      OpenDropped(path, engine, state);
    }
    if (state->scene.number != titled) {
      titled = state->scene.number;
      window->SetTitle(Title(state->scene.request));
    }
    state->keys = window->TakeKeys();
    window->SetFullscreen(state->fullscreen);
    DrawFrame(now, now - last, &lively, window, &textures, &times, engine, state);
    frames_due = std::max(frames_due - 1, 0);
    last = now;
  }
  return times;
}

}  // namespace

Status RunViewer(const ViewOptions& options) {
  Result<std::unique_ptr<GlWindow>> window =
      GlWindow::Create(options.settings.width, options.settings.height, Title(options.request));
  if (!window.ok()) {
    return window.status();
  }
  CatchInterrupts();
  ViewerState state;
  state.settings = options.settings;
  state.preset = options.preset;
  state.request = options.request;
  state.views = ListViews(state.settings.denoise);
  // The engine is destroyed before the window, which its threads wake.
  std::atomic<bool> news = false;
  const auto wake = [&news] {
    news = true;
    GlWindow::Wake();
  };
  auto engine = std::make_unique<ViewEngine>(state.settings, wake, options.devices);
  engine->Open(options.request);
  const InterfaceTimes times =
      Loop(!options.report.empty(), window->get(), &news, engine.get(), &state);
  (*window)->Hide();
  engine.reset();
  const Status status = options.report.empty() ? Status::Ok() : times.Write(options.report);
  if (SceneLoader::abandoned() > 0 && status.ok()) {
    // An obsolete scene is still being read. Nothing needs to be saved, hence the program does not
    // wait; libraries must not be unloaded during the read.
    window->reset();
    std::fflush(nullptr);
    std::_Exit(EXIT_SUCCESS);
  }
  SceneLoader::WaitForAbandoned();
  return status;
}

}  // namespace stillray::view
