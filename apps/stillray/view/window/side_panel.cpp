// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The panel on the right, the menu at the top, and the animation bar.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <imgui.h>

#include "view/window/panels.h"

namespace stillray::view {
namespace {

bool Section(const char* name, bool open) {
  return ImGui::CollapsingHeader(name, open ? ImGuiTreeNodeFlags_DefaultOpen : 0);
}

void SceneMenu(ViewEngine* engine, ViewerState* state) {
  if (ImGui::MenuItem("Open scene...", "Ctrl+O")) {
    OpenDialog(Dialog::kOpenScene, state);
  }
  if (ImGui::BeginMenu("Built-in")) {
    for (const std::string& name : BuiltinSceneNames()) {
      if (ImGui::MenuItem(name.c_str())) {
        state->request = {"builtin:" + name, ""};
        engine->Open(state->request);
      }
    }
    ImGui::EndMenu();
  }
  if (ImGui::MenuItem("Environment map...")) {
    OpenDialog(Dialog::kOpenEnvironment, state);
  }
  ImGui::Separator();
  if (ImGui::MenuItem("Save picture...", "Ctrl+S")) {
    OpenDialog(Dialog::kSavePicture, state);
  }
  if (state->recording) {
    if (ImGui::MenuItem("End the clip", "Ctrl+R")) {
      engine->StopClip();
    }
  } else if (ImGui::MenuItem("Record a clip...", "Ctrl+R")) {
    OpenDialog(Dialog::kRecordClip, state);
  }
  ImGui::Separator();
  if (ImGui::MenuItem("Quit", "Ctrl+Q")) {
    state->quit = true;
  }
}

void ViewMenu(ViewerState* state) {
  if (ImGui::MenuItem("denoised")) {
    SetPanes({"denoised"}, state);
  }
  if (ImGui::MenuItem("noisy | denoised", "Tab")) {
    SetPanes({"noisy", "denoised"}, state);
  }
  if (ImGui::MenuItem("noisy | denoised | reference")) {
    SetPanes({"noisy", "denoised", "reference"}, state);
  }
  if (ImGui::MenuItem("before | after the wavelet")) {
    SetPanes({"temporal", "denoised"}, state);
  }
  ImGui::Separator();
  ImGui::MenuItem("Side panel", "F2", &state->show_panel);
  ImGui::MenuItem("Full screen", "F11", &state->fullscreen);
  state->changed |=
      ImGui::MenuItem("Nearest-neighbour upscaling", nullptr, &state->settings.sharp_pixels);
}

}  // namespace

void DrawMenu(ViewEngine* engine, ViewerState* state) {
  if (!ImGui::BeginMainMenuBar()) {
    return;
  }
  if (ImGui::BeginMenu("Scene")) {
    SceneMenu(engine, state);
    ImGui::EndMenu();
  }
  if (ImGui::BeginMenu("View")) {
    ViewMenu(state);
    ImGui::EndMenu();
  }
  if (ImGui::BeginMenu("Settings")) {
    for (const std::string_view name : PresetNames()) {
      const std::string text(name);
      if (ImGui::MenuItem(text.c_str(), nullptr, text == state->preset)) {
        SetPreset(text, state);
      }
    }
    ImGui::Separator();
    if (ImGui::MenuItem("Load...")) {
      OpenDialog(Dialog::kLoadSettings, state);
    }
    if (ImGui::MenuItem("Save...")) {
      OpenDialog(Dialog::kSaveSettings, state);
    }
    ImGui::EndMenu();
  }
  if (ImGui::MenuItem("Keys")) {
    state->show_help = true;
  }
  if (state->scene.number > 0) {
    const std::string text =
        fmt::format("{}   {} triangles", state->scene.request.scene, state->scene.triangles);
    const float room = ImGui::GetWindowWidth() - ImGui::CalcTextSize(text.c_str()).x - 16;
    ImGui::SameLine(std::max(room, ImGui::GetCursorPosX() + 20));
    ImGui::TextDisabled("%s", text.c_str());
  }
  ImGui::EndMainMenuBar();
}

namespace {

bool SpeedSlider(const char* id, const char* format, double* speed) {
  auto value = static_cast<float>(*speed);
  if (!ImGui::SliderFloat(id, &value, -4, 4, format)) {
    return false;
  }
  *speed = std::abs(value) < 0.04f ? 0 : std::clamp(value, -8.0f, 8.0f);
  return true;
}

}  // namespace

void DrawPlaybackBar(const Rect& area, ViewerState* state) {
  ImGui::SetNextWindowPos({area.x, area.y});
  ImGui::SetNextWindowSize({area.width, area.height});
  ImGui::Begin("playback", nullptr,
               ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove |
                   ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoNav);
  ViewSettings& s = state->settings;
  const float em = ImGui::GetFontSize();
  const double length = state->scene.length;
  if (length <= 0) {
    ImGui::AlignTextToFramePadding();
    ImGui::TextDisabled(state->scene.number > 0 ? "nothing is animated in this scene" : "");
    ImGui::End();
    return;
  }
  if (ImGui::Button(s.playing ? "Pause##play" : "Play##play", {4 * em, 0})) {
    s.playing = !s.playing;
    state->changed = true;
  }
  ImGui::SameLine();
  if (ImGui::Button("<", {1.8f * em, 0})) {
    StepFrames(-1, state);
  }
  ImGui::SameLine(0, 3);
  if (ImGui::Button(">", {1.8f * em, 0})) {
    StepFrames(1, state);
  }
  ImGui::SameLine();
  const float room = ImGui::GetContentRegionAvail().x;
  const float speed_width = std::min((state->scene.moving_lights ? 17 : 10) * em, room * 0.6f);
  const float time_width = std::max(room - speed_width - 8, 2 * em);
  ImGui::SetNextItemWidth(time_width);
  const std::string time_format =
      time_width < 8 * em ? "%.2f s" : fmt::format("%.2f / {:.2f} s", length);
  auto seconds = static_cast<float>(state->frame != nullptr ? state->frame->seconds : 0);
  if (ImGui::SliderFloat("##time", &seconds, 0, static_cast<float>(length), time_format.c_str(),
                         ImGuiSliderFlags_AlwaysClamp)) {
    Seek(seconds, state);
  }
  ImGui::SameLine();
  ImGui::SetNextItemWidth(state->scene.moving_lights ? speed_width / 2 - 4 : -1);
  state->changed |= SpeedSlider("##speed", "speed %.2f", &s.speed);
  if (state->scene.moving_lights) {
    double lights = s.light_speed.value_or(s.speed);
    ImGui::SameLine(0, 4);
    ImGui::SetNextItemWidth(-1);
    if (SpeedSlider("##lights", "lights %.2f", &lights)) {
      s.light_speed = lights;
      state->changed = true;
    }
    if (ImGui::IsItemHovered()) {
      ImGui::SetTooltip("Speed of the lights that move; the other one is that of all else.");
    }
  }
  ImGui::End();
}

void DrawSidePanel(const Rect& area, ViewerState* state) {
  ImGui::SetNextWindowPos({area.x, area.y});
  ImGui::SetNextWindowSize({area.width, area.height});
  ImGui::Begin("panel", nullptr,
               ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove |
                   ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoSavedSettings |
                   ImGuiWindowFlags_AlwaysVerticalScrollbar);
  if (Section("View", true)) {
    DrawViewPanel(state);
  }
  if (Section("Path tracer", true)) {
    DrawRenderPanel(state);
  }
  if (Section("Denoiser", true)) {
    DrawParameterPanel(state);
  }
  if (Section("Camera", false)) {
    DrawCameraPanel(state);
  }
  if (Section("Times and memory", true)) {
    DrawTimePanel(*state);
  }
  if (Section("Error vs. reference", false)) {
    DrawMeasurePanel(state);
  }
  if (Section("Pixel inspector", false)) {
    DrawInspectorPanel(state);
  }
  ImGui::End();
}

}  // namespace stillray::view
