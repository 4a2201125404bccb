// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Selects views and camera.
#include <algorithm>

#include <fmt/format.h>
#include <imgui.h>

#include "view/window/panels.h"
#include "view/window/widgets.h"

namespace stillray::view {
namespace {

void ViewCombo(size_t pane, ViewerState* state) {
  const std::string label = fmt::format("##pane{}", pane);
  // a copy, since a choice replaces the list
  const std::string current = state->settings.panes[pane];
  ImGui::SetNextItemWidth(-1);
  if (!ImGui::BeginCombo(label.c_str(), current.c_str(), ImGuiComboFlags_HeightLarge)) {
    return;
  }
  std::string group;
  for (const ViewInfo& view : state->views) {
    if (view.group != group) {
      group = view.group;
      ImGui::TextDisabled("%s", group.c_str());
    }
    const bool chosen = view.name == current;
    if (ImGui::Selectable(("  " + view.name).c_str(), chosen)) {
      std::vector<std::string> panes = state->settings.panes;
      panes[pane] = view.name;
      SetPanes(std::move(panes), state);
    }
    if (chosen && ImGui::IsWindowAppearing()) {
      ImGui::SetScrollHereY(0.3f);
    }
  }
  ImGui::EndCombo();
}

void CountButtons(ViewerState* state) {
  static const std::vector<std::string> kFill = {"denoised", "noisy", "reference"};
  ImGui::AlignTextToFramePadding();
  ImGui::TextUnformatted("Split view");
  for (int count = 1; count <= 3; ++count) {
    ImGui::SameLine();
    if (ImGui::RadioButton(fmt::format("{}", count).c_str(),
                           static_cast<int>(state->settings.panes.size()) == count)) {
      static const std::vector<std::string> kTriples[] = {
          {"denoised"}, {"noisy", "denoised"}, {"noisy", "denoised", "reference"}};
      SetPanes(kTriples[count - 1], state);
    }
  }
}

/// Orbit controls. The radius is initialised with the camera's distance and kept until the orbit
/// ends.
void DrawOrbit(ViewerState* state) {
  ViewSettings& s = state->settings;
  bool orbits = s.orbiting;
  if (ImGui::Checkbox("Orbit", &orbits)) {
    SetOrbit(orbits, state);
  }
  HelpMark("The camera circles around its orbit centre (key O). Moving it by hand ends the orbit.");
  if (!s.orbiting) {
    return;
  }
  auto speed = static_cast<float>(s.orbit_speed);
  if (LabelledSlider("Speed", "degrees/s", &speed, -90.0f, 90.0f, "%.0f")) {
    s.orbit_speed = speed;
    state->changed = true;
  }
  const ViewPose& pose = state->frame->pose;
  float radius = s.orbit_radius > 0 ? s.orbit_radius : glm::length(pose.Focus() - pose.position);
  LabelFor("Radius");
  if (ImGui::DragFloat("##radius", &radius, 0.01f * radius, 1e-4f, 1e6f, "%.3g")) {
    s.orbit_radius = std::clamp(radius, 1e-4f, 1e6f);
    state->changed = true;
  }
}

}  // namespace

void DrawViewPanel(ViewerState* state) {
  CountButtons(state);
  for (size_t pane = 0; pane < state->settings.panes.size(); ++pane) {
    ViewCombo(pane, state);
  }
  Settings& denoise = state->settings.denoise;
  state->changed |= LabelledSlider("Exposure", "EV", &denoise.exposure, -8.0f, 8.0f, "%.2f");
  const char* kCurves[] = {"linear", "reinhard", "filmic", "aces"};
  int curve = static_cast<int>(denoise.tonemap);
  if (LabelledCombo("Tone mapping", &curve, kCurves, 4)) {
    denoise.tonemap = static_cast<Tonemap>(curve);
    state->changed = true;
  }
  state->changed |= ImGui::Checkbox("Nearest-neighbour upscaling", &state->settings.sharp_pixels);
  HelpMark("Enlarges the picture without interpolation.");
}

void DrawCameraPanel(ViewerState* state) {
  const ViewSettings& s = state->settings;
  std::string current = "free";
  const auto& names = state->scene.cameras;
  const auto label = [&](size_t i) {
    return names[i].empty() ? fmt::format("camera {}", i) : names[i];
  };
  if (!s.free_camera && static_cast<size_t>(s.camera) < names.size()) {
    current = label(static_cast<size_t>(s.camera));
  }
  LabelFor("Camera");
  if (ImGui::BeginCombo("##camera", current.c_str())) {
    for (size_t i = 0; i < names.size(); ++i) {
      const std::string id = fmt::format("{}##{}", label(i), i);
      if (ImGui::Selectable(id.c_str(), !s.free_camera && s.camera == static_cast<int>(i))) {
        UseFileCamera(static_cast<int>(i), state);
      }
    }
    if (ImGui::Selectable("free", s.free_camera) && state->frame != nullptr) {
      SetPose(state->frame->pose, state);
    }
    ImGui::EndCombo();
  }
  if (state->frame == nullptr) {
    return;
  }
  DrawOrbit(state);
  ViewPose pose = s.free_camera && !s.orbiting ? s.pose : state->frame->pose;
  constexpr float kDegrees = 57.29578f;
  float degrees = pose.yfov * kDegrees;
  if (LabelledSlider("Angle of view", "degrees", &degrees, 5.0f, 120.0f, "%.1f")) {
    pose.yfov = degrees / kDegrees;
    SetPose(pose, state);
  }
  ImGui::TextDisabled("at %.3g %.3g %.3g, %.3g to the focus", pose.position.x, pose.position.y,
                      pose.position.z, pose.distance);
  ImGui::TextUnformatted("Views");
  HelpMark("Ctrl and a digit saves the view, the digit alone goes there. Saved views are lit.");
  for (size_t i = 0; i < state->saved_views.size(); ++i) {
    ImGui::SameLine(0, i == 0 ? -1.0f : 3.0f);
    const bool saved = state->saved_views[i].has_value();
    ImGui::PushStyleVar(ImGuiStyleVar_Alpha, saved ? 1.0f : 0.35f);
    if (ImGui::SmallButton(fmt::format("{}", i + 1).c_str())) {
      GoToSavedView(i, state);
    }
    ImGui::PopStyleVar();
  }
}

}  // namespace stillray::view
