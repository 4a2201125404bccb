// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Keys of the whole window.
#include <GLFW/glfw3.h>
#include <imgui.h>

#include "view/window/panels.h"

namespace stillray::view {
namespace {

bool Pressed(int key) {
  return ImGui::IsKeyPressed(key, false);
}

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

void ControlKeys(ViewEngine* engine, ViewerState* state) {
  if (Pressed(GLFW_KEY_O)) {
    OpenDialog(Dialog::kOpenScene, state);
  }
  if (Pressed(GLFW_KEY_S)) {
    OpenDialog(Dialog::kSavePicture, state);
  }
  if (Pressed(GLFW_KEY_R)) {
    if (state->recording) {
      engine->StopClip();
    } else {
      OpenDialog(Dialog::kRecordClip, state);
    }
  }
}

void InspectorKey(ViewerState* state) {
  ViewSettings& s = state->settings;
  if (!s.inspect) {
    s.inspect = true;
    state->changed = true;
  } else {
    state->inspector_pinned = !state->inspector_pinned;
  }
}

void PlainKeys(ViewerState* state) {
  ViewSettings& s = state->settings;
  if (Pressed(GLFW_KEY_SPACE)) {
    s.playing = !s.playing;
    state->changed = true;
  }
  if (ImGui::IsKeyPressed(GLFW_KEY_PERIOD)) {
    StepFrames(1, state);
  }
  if (ImGui::IsKeyPressed(GLFW_KEY_COMMA)) {
    StepFrames(-1, state);
  }
  if (Pressed(GLFW_KEY_R)) {
    ++s.restart;
    state->changed = true;
  }
  if (Pressed(GLFW_KEY_P)) {
    NextPreset(state);
  }
  if (Pressed(GLFW_KEY_TAB)) {
    NextPanes(state);
  }
  if (Pressed(GLFW_KEY_HOME)) {
    UseFileCamera(s.camera, state);
  }
  if (Pressed(GLFW_KEY_I)) {
    InspectorKey(state);
  }
}

}  // namespace

void HandleKeys(ViewEngine* engine, ViewerState* state) {
  const ImGuiIO& io = ImGui::GetIO();
  if (io.KeyCtrl && Pressed(GLFW_KEY_Q)) {
    state->quit = true;  // whatever is open
  }
  const bool busy = state->dialog != Dialog::kNone || !state->errors.empty();
  if (io.WantTextInput || busy) {
    return;
  }
  if (Pressed(GLFW_KEY_F1)) {
    state->show_help = !state->show_help;
  }
  if (Pressed(GLFW_KEY_F2)) {
    state->show_panel = !state->show_panel;
  }
  for (size_t i = 0; i < state->saved_views.size(); ++i) {
    if (Pressed(GLFW_KEY_1 + static_cast<int>(i))) {
      if (io.KeyCtrl) {
        SaveView(i, state);
      } else {
        GoToSavedView(i, state);
      }
    }
  }
  if (io.KeyCtrl) {
    ControlKeys(engine, state);
  } else {
    PlainKeys(state);
  }
}

}  // namespace stillray::view
