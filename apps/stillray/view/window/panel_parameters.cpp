// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The denoiser's parameters: widgets are generated from the table.
#include <algorithm>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <imgui.h>
#include <imgui_stdlib.h>

#include "view/exact_accumulation.h"
#include "view/window/panels.h"
#include "view/window/widgets.h"

namespace stillray::view {
namespace {

/// Ranges larger than this factor use a logarithmic scale.
constexpr double kLogarithmic = 50;
const ImVec4 kChanged = {0.55f, 0.85f, 1.0f, 1.0f};
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

void Tooltip(const Parameter& p, const std::string& preset_value) {
  if (!ImGui::IsItemHovered()) {
    return;
  }
  ImGui::BeginTooltip();
  ImGui::PushTextWrapPos(ImGui::GetFontSize() * 26);
  ImGui::TextUnformatted(p.name);
  ImGui::TextUnformatted(p.help);
  std::string facts;
  if (p.type == ParameterType::kFloat || p.type == ParameterType::kInt) {
    facts = fmt::format("{} to {} {}\n", p.min, p.max, p.unit);
  }
  facts += *p.symbol != '\0' ? fmt::format("in the papers: {}\n", p.symbol) : "";
  facts += "preset: " + preset_value;
  ImGui::TextDisabled("%s", facts.c_str());
  ImGui::PopTextWrapPos();
  ImGui::EndTooltip();
}

ImGuiSliderFlags SliderFlags(const Parameter& p) {
  const bool wide = p.min >= 0 && p.max - p.min > kLogarithmic * std::max(p.min, 1.0);
  return ImGuiSliderFlags_AlwaysClamp | (wide ? ImGuiSliderFlags_Logarithmic : 0);
}

void FloatWidget(const Parameter& p, const std::string& value, ViewerState* state) {
  float number = std::stof(value);
  const std::string format = *p.unit == '\0' ? "%.4g" : fmt::format("%.4g {}", p.unit);
  if (ImGui::SliderFloat("##value", &number, static_cast<float>(p.min), static_cast<float>(p.max),
                         format.c_str(), SliderFlags(p))) {
    Assign(p, fmt::format("{}", number), state);
  }
}

void IntWidget(const Parameter& p, const std::string& value, ViewerState* state) {
  int number = std::stoi(value);
  const std::string format = *p.unit == '\0' ? "%d" : fmt::format("%d {}", p.unit);
  if (ImGui::SliderInt("##value", &number, static_cast<int>(p.min), static_cast<int>(p.max),
                       format.c_str(), SliderFlags(p))) {
    Assign(p, fmt::format("{}", number), state);
  }
}

void ChoiceWidget(const Parameter& p, const std::string& value, ViewerState* state) {
  if (!ImGui::BeginCombo("##value", value.c_str())) {
    return;
  }
  for (const char* choice : p.choices) {
    if (ImGui::Selectable(choice, value == choice)) {
      Assign(p, choice, state);
    }
  }
  ImGui::EndCombo();
}

void TextWidget(const Parameter& p, const std::string& value, ViewerState* state) {
  std::string text = value;
  if (ImGui::InputText("##value", &text, ImGuiInputTextFlags_EnterReturnsTrue)) {
    Assign(p, text, state);
  }
}

void Widget(const Parameter& p, ViewerState* state) {
  const std::string value = ValueOf(state->settings.denoise, p);
  const std::string preset_value = PresetValue(*state, p);
  const bool changed = value != preset_value;
  ImGui::PushID(p.name);
  ImGui::AlignTextToFramePadding();
  if (changed) {
    ImGui::PushStyleColor(ImGuiCol_Text, kChanged);
  }
  ImGui::TextUnformatted(p.name);
  if (changed) {
    ImGui::PopStyleColor();
  }
  Tooltip(p, preset_value);
  const float reset_width = ImGui::GetFrameHeight();
  ImGui::SameLine(ImGui::GetWindowContentRegionMax().x * 0.48f);
  ImGui::SetNextItemWidth(-(reset_width + ImGui::GetStyle().ItemInnerSpacing.x));
  switch (p.type) {
    case ParameterType::kFloat:
      FloatWidget(p, value, state);
      break;
    case ParameterType::kInt:
      IntWidget(p, value, state);
      break;
    case ParameterType::kFlag: {
      bool on = value == "on";
      if (ImGui::Checkbox("##value", &on)) {
        Assign(p, on ? "on" : "off", state);
      }
      break;
    }
    case ParameterType::kChoice:
      ChoiceWidget(p, value, state);
      break;
    case ParameterType::kSteps:
    case ParameterType::kSeed:
    case ParameterType::kRate:
      TextWidget(p, value, state);
      break;
  }
  Tooltip(p, preset_value);
  if (changed) {
    ImGui::SameLine(ImGui::GetWindowContentRegionMax().x - reset_width);
    if (ImGui::Button("x", {reset_width, 0})) {
      Assign(p, preset_value, state);
    }
    if (ImGui::IsItemHovered()) {
      ImGui::SetTooltip("back to %s", preset_value.c_str());
    }
  }
  ImGui::PopID();
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
          Widget(p, state);
        }
      }
    }
  }
}

}  // namespace stillray::view
