// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Samples, resolution and light paths.
#include <optional>
#include <string>
#include <string_view>

#include <fmt/format.h>
#include <imgui.h>

#include "view/window/panels.h"
#include "view/window/parameter_widget.h"
#include "view/window/widgets.h"

namespace stillray::view {
namespace {

void RateRow(ViewerState* state) {
  ViewSettings& s = state->settings;
  if (ImGui::Checkbox("Adaptive sampling rate", &s.auto_rate)) {
    if (!s.auto_rate && state->frame != nullptr) {
      s.rate = state->frame->rate;
    }
    state->changed = true;
  }
  HelpMark(
      "While something moves, the rate follows the target frame time. Once nothing moves, frames "
      "have one sample per pixel or more.");
  if (s.auto_rate) {
    auto target = static_cast<float>(s.target_ms);
    if (LabelledSlider("Target frame time", "ms", &target, 10.0f, 500.0f, "%.0f")) {
      s.target_ms = target;
      state->changed = true;
    }
    return;
  }
  LabelFor("Samples");
  if (ImGui::BeginCombo("##samples", (ToText(s.rate) + " per pixel").c_str())) {
    for (SampleRate rate{1, kMaxCycle};; rate = Doubled(rate)) {
      if (ImGui::Selectable(ToText(rate).c_str(), rate == s.rate)) {
        s.rate = rate;
        state->changed = true;
      }
      if (rate == Doubled(rate)) {
        break;
      }
    }
    ImGui::EndCombo();
  }
}

void ScaleRow(ViewerState* state) {
  ViewSettings& s = state->settings;
  float percent = s.scale * 100;
  if (LabelledSlider("Resolution", "%%", &percent, 10.0f, 100.0f, "%.0f")) {
    s.scale = percent / 100;
    state->changed = true;
  }
  state->changed |= ImGui::Checkbox("Dynamic resolution", &s.auto_scale);
  HelpMark(
      "While something moves and even the fewest samples take too long, the picture gets smaller, "
      "down to a quarter of this width and height. Once nothing moves it has all of it.");
  state->changed |= ImGui::Checkbox("Fast filter while moving", &s.fast_filter);
  HelpMark(
      "While something moves and frames take too long: psvgf and sparse guides instead of the "
      "filter below, before the resolution falls. Only with the adaptive sampling rate, where the "
      "views are denoised, noisy and reference, and without the pixel inspector.");
  const ViewFrame* f = state->frame;
  const ImVec4 amber = {1.0f, 0.78f, 0.35f, 1.0f};
  if (f != nullptr && f->fast_filter) {
    ImGui::TextColored(amber, "Moving: psvgf, sparse guides");
  }
  if (f != nullptr && f->scale < f->chosen_scale * 0.99f) {
    ImGui::TextColored(amber, "Dynamic resolution: %.0f %% (%dx%d)",
                       static_cast<double>(f->scale * 100), f->width, f->height);
  }
}

void RenderParameterRow(const Parameter& p, ViewerState* state) {
  RenderSettings* render = &state->settings.render;
  const std::string value = GetRenderParameter(*render, p.name).value();
  const std::optional<std::string> changed =
      ParameterWidget(p, value, "default", GetRenderParameter({}, p.name).value());
  if (changed && SetRenderParameter(render, p.name, *changed).ok()) {
    state->changed = true;
  }
}

/// Light paths are changed most often; the other groups are collapsed.
void RenderParameterGroups(ViewerState* state) {
  std::string_view group;
  bool open = false;
  for (const Parameter& p : RenderParameters()) {
    if (p.type == ParameterType::kRate) {  // RateRow
      continue;
    }
    if (group != p.group) {
      group = p.group;
      open =
          ImGui::TreeNodeEx(p.group, ImGuiTreeNodeFlags_NoTreePushOnOpen |
                                         (group == "paths" ? ImGuiTreeNodeFlags_DefaultOpen : 0));
    }
    if (open) {
      RenderParameterRow(p, state);
    }
  }
}

}  // namespace

void DrawRenderPanel(ViewerState* state) {
  ViewSettings& s = state->settings;
  RateRow(state);
  ScaleRow(state);
  RenderParameterGroups(state);
  if (ImGui::Button("Reset accumulation")) {
    ++s.restart;
    state->changed = true;
  }
  HelpMark("Discards all history (R).");
}

}  // namespace stillray::view
