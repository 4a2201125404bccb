// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Keyboard shortcuts of the window.
#include <GLFW/glfw3.h>
#include <imgui.h>

#include "core/clock.h"
#include "view/window/panels.h"

namespace stillray::view {
namespace {

void NextPanes(ViewerState* state) {
  switch (state->settings.panes.size()) {
    case 1:
      return SetPanes({"noisy", "denoised"}, state);
    case 2:
      return SetPanes({"noisy", "denoised", "reference"}, state);
    default:
      return SetPanes({"denoised"}, state);
  }
}

void ControlKey(int key, ViewEngine* engine, ViewerState* state) {
  switch (key) {
    case GLFW_KEY_O:
      return OpenDialog(Dialog::kOpenScene, state);
    case GLFW_KEY_S:
      return OpenDialog(Dialog::kSavePicture, state);
    case GLFW_KEY_R:
      if (state->recording) {
        engine->StopClip();
      } else {
        OpenDialog(Dialog::kRecordClip, state);
      }
      return;
    default:
      return;
  }
}

void InspectorKey(ViewerState* state) {
  ViewSettings& s = state->settings;
  if (ImGui::GetIO().KeyShift) {
    state->changed |= s.inspect;
    s.inspect = false;
  } else if (!s.inspect) {
    s.inspect = true;
    state->inspector_pinned = false;
    state->changed = true;
  } else {
    state->inspector_pinned = !state->inspector_pinned;
  }
}

void PlainKey(int key, ViewerState* state) {
  ViewSettings& s = state->settings;
  switch (key) {
    case GLFW_KEY_SPACE:
      s.playing = !s.playing;
      state->changed = true;
      return;
    case GLFW_KEY_R:
      ++s.restart;
      state->changed = true;
      return;
    case GLFW_KEY_P:
      NextPreset(state);
      AddToast("preset " + state->preset, SecondsNow(), state);
      return;
    case GLFW_KEY_TAB:
      return NextPanes(state);
    case GLFW_KEY_HOME:
      return UseFileCamera(s.camera, state);
    case GLFW_KEY_O:
      return SetOrbit(!s.orbiting, state);
    case GLFW_KEY_I:
      return InspectorKey(state);
    default:
      return;
  }
}

/// Keys that repeat while held.
void StepKey(int key, ViewerState* state) {
  if (key == GLFW_KEY_PERIOD) {
    StepFrames(1, state);
  } else if (key == GLFW_KEY_COMMA) {
    StepFrames(-1, state);
  }
}

void SavedViewKey(const KeyPress& press, ViewerState* state) {
  const int view = press.key - GLFW_KEY_1;
  if (view < 0 || view >= static_cast<int>(state->saved_views.size())) {
    return;
  }
  if (press.control) {
    SaveView(static_cast<size_t>(view), state);
  } else {
    GoToSavedView(static_cast<size_t>(view), state);
  }
}

void HandleKey(const KeyPress& press, ViewEngine* engine, ViewerState* state) {
  if (press.control && press.key == GLFW_KEY_Q) {
    state->quit = true;  // regardless of open dialogs
  }
  const bool busy = state->dialog != Dialog::kNone || !state->errors.empty();
  if (ImGui::GetIO().WantTextInput || busy) {
    return;
  }
  if (!press.control) {
    StepKey(press.key, state);
  }
  if (press.repeated) {
    return;
  }
  if (press.key == GLFW_KEY_F1) {
    state->show_help = !state->show_help;
  } else if (press.key == GLFW_KEY_F2) {
    state->show_panel = !state->show_panel;
  } else if (press.key == GLFW_KEY_F11) {
    state->fullscreen = !state->fullscreen;
  }
  SavedViewKey(press, state);
  if (press.control) {
    ControlKey(press.key, engine, state);
  } else {
    PlainKey(press.key, state);
  }
}

}  // namespace

void HandleKeys(ViewEngine* engine, ViewerState* state) {
  for (const KeyPress& press : state->keys) {
    HandleKey(press, engine, state);
  }
}

}  // namespace stillray::view
