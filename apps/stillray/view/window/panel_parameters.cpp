// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The denoiser's parameters: widgets are generated from the table.
#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include <imgui.h>

#include "view/exact_accumulation.h"
#include "view/window/panels.h"
#include "view/window/parameter_widget.h"
#include "view/window/widgets.h"

namespace stillray::view {
namespace {

const ImVec4 kWrong = {1.0f, 0.45f, 0.4f, 1.0f};

std::string ValueOf(const Settings& settings, const Parameter& p) {
  return GetParameter(settings, p.name).value();
}

std::string PresetValue(const ViewerState& state, const Parameter& p) {
  const Result<Settings> preset = PresetSettings(state.preset);
  return preset.ok() ? ValueOf(preset.value(), p) : ValueOf(Settings(), p);
}

/// Applies the value if it is valid and does not contradict others.
void Assign(const Parameter& p, const std::string& value, ViewerState* state) {
  Settings changed = state->settings.denoise;
  Status status = SetParameter(&changed, p.name, value);
  status = status.ok() ? ValidateSettings(changed) : status;
  state->parameter_error = status.message();
  if (status.ok()) {
    state->settings.denoise = changed;
    state->changed = true;
  }
}

void ParameterRow(const Parameter& p, ViewerState* state) {
  const std::string value = ValueOf(state->settings.denoise, p);
  const std::optional<std::string> changed =
      ParameterWidget(p, value, "preset", PresetValue(*state, p));
  if (changed) {
    Assign(p, *changed, state);
  }
}

std::vector<std::string> Groups() {
  std::vector<std::string> groups;
  for (const Parameter& p : Parameters()) {
    // Exposure and curve are in the view panel.
    if (std::string(p.group) != "tonemap" &&
        std::find(groups.begin(), groups.end(), p.group) == groups.end()) {
      groups.emplace_back(p.group);
    }
  }
  return groups;
}

void PresetRow(ViewerState* state) {
  LabelFor("Preset");
  if (ImGui::BeginCombo("##preset", state->preset.c_str())) {
    for (const std::string_view name : PresetNames()) {
      if (ImGui::Selectable(std::string(name).c_str(), name == state->preset)) {
        SetPreset(std::string(name), state);
      }
    }
    ImGui::EndCombo();
  }
}

void StillHistoryRow(ViewerState* state) {
  state->changed |=
      ImGui::Checkbox("Converge while nothing moves", &state->settings.still_converges);
  HelpMark(
      "Once nothing moves, all samples are weighted equally and the picture converges. Only where "
      "the views are denoised, noisy and reference, and without the pixel inspector: other views "
      "show the parameters below as they are.");
}

void ExactRow(ViewerState* state) {
  bool exact = AccumulatesExactly(state->settings.denoise);
  if (ImGui::Checkbox("Progressive accumulation (unbiased)", &exact)) {
    const Result<Settings> preset = PresetSettings(state->preset);
    SetExactAccumulation(exact, preset.ok() ? preset.value() : Settings(),
                         &state->settings.denoise);
    state->changed = true;
  }
  HelpMark(
      "All samples are weighted equally, and no filtered light is fed back: a still view "
      "converges. Moving light leaves trails.");
}

}  // namespace

void DrawParameterPanel(ViewerState* state) {
  static const std::vector<std::string> kGroups = Groups();
  PresetRow(state);
  StillHistoryRow(state);
  ExactRow(state);
  if (!state->parameter_error.empty()) {
    ImGui::PushTextWrapPos(0);
    ImGui::TextColored(kWrong, "%s", state->parameter_error.c_str());
    ImGui::PopTextWrapPos();
  }
  for (const std::string& group : kGroups) {
    if (ImGui::TreeNodeEx(group.c_str(), ImGuiTreeNodeFlags_NoTreePushOnOpen)) {
      for (const Parameter& p : Parameters()) {
        if (group == p.group) {
          ParameterRow(p, state);
        }
      }
    }
  }
}

}  // namespace stillray::view
