// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "view/window/camera_input.h"

#include <algorithm>

#include <GLFW/glfw3.h>
#include <imgui.h>

namespace stillray::view {
namespace {

constexpr float kRadiansPerPixel = 0.005f;
constexpr float kDistancesPerSecond = 0.6f;
constexpr float kFast = 4;
constexpr float kClickPixels = 4;  // a longer movement is a drag
// Maximum time step in seconds, so that the camera does not jump after a pause.
constexpr double kLongestStep = 0.1;

ViewPose CurrentPose(const ViewerState& state) {
  const ViewSettings& s = state.settings;
  return s.free_camera && !s.orbiting ? s.pose : state.frame->pose;
}

/// Requests the depth under the mouse, which is part of one of the next frames.
void AskForFocus(bool turn, const Rect& area, ImVec2 mouse, ViewerState* state) {
  ++state->settings.focus;
  state->focus_asked = state->settings.focus;
  state->focus_turns = turn;
  state->settings.focus_x = std::clamp((mouse.x - area.x) / area.width, 0.0f, 1.0f);
  state->settings.focus_y = std::clamp((mouse.y - area.y) / area.height, 0.0f, 1.0f);
  state->changed = true;
}

}  // namespace

void HandleCameraMouse(const Rect& area, ViewerState* state) {
  if (state->frame == nullptr) {
    return;
  }
  const ImGuiIO& io = ImGui::GetIO();
  const bool hovered = ImGui::IsItemHovered();
  const bool active = ImGui::IsItemActive();
  if (hovered && ImGui::IsMouseDoubleClicked(ImGuiMouseButton_Left)) {
    AskForFocus(true, area, io.MousePos, state);
    return;
  }
  if (hovered && ImGui::IsMouseReleased(ImGuiMouseButton_Left) && !io.KeyShift &&
      io.MouseDragMaxDistanceSqr[ImGuiMouseButton_Left] < kClickPixels * kClickPixels &&
      io.MouseClickedLastCount[ImGuiMouseButton_Left] == 1) {
    AskForFocus(false, area, io.MousePos, state);
  }
  const ViewPose pose = CurrentPose(*state);
  const float dx = io.MouseDelta.x;
  const float dy = io.MouseDelta.y;
  if (active && (dx != 0 || dy != 0)) {
    const float right = dx * kRadiansPerPixel;
    const float down = dy * kRadiansPerPixel;
    if (ImGui::IsMouseDown(ImGuiMouseButton_Middle) ||
        (ImGui::IsMouseDown(ImGuiMouseButton_Left) && io.KeyShift)) {
      SetPose(Pan(pose, dx, dy, area.height), state);
    } else if (ImGui::IsMouseDown(ImGuiMouseButton_Right)) {
      SetPose(Look(pose, right, down), state);
    } else if (ImGui::IsMouseDown(ImGuiMouseButton_Left)) {
      SetPose(Orbit(pose, right, down), state);
    }
  }
  if (hovered && io.MouseWheel != 0) {
    SetPose(io.KeyCtrl ? Zoom(pose, io.MouseWheel) : Dolly(pose, io.MouseWheel), state);
  }
}

bool HandleFlyKeys(double elapsed, ViewerState* state) {
  const ImGuiIO& io = ImGui::GetIO();
  if (io.WantTextInput || io.KeyCtrl || state->frame == nullptr) {
    return false;
  }
  const auto axis = [](int plus, int minus) {
    return static_cast<float>(ImGui::IsKeyDown(plus)) - static_cast<float>(ImGui::IsKeyDown(minus));
  };
  const float right = axis(GLFW_KEY_D, GLFW_KEY_A);
  const float forward = axis(GLFW_KEY_W, GLFW_KEY_S);
  const float up = axis(GLFW_KEY_E, GLFW_KEY_Q);
  if (right == 0 && forward == 0 && up == 0) {
    return false;
  }
  const ViewPose pose = CurrentPose(*state);
  const float step = pose.distance * kDistancesPerSecond * (io.KeyShift ? kFast : 1) *
                     static_cast<float>(std::min(elapsed, kLongestStep));
  SetPose(Fly(pose, right * step, up * step, forward * step), state);
  return true;
}

}  // namespace stillray::view
