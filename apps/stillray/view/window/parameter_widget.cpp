// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "view/window/parameter_widget.h"

#include <algorithm>

#include <fmt/format.h>
#include <imgui.h>
#include <imgui_stdlib.h>

namespace stillray::view {
namespace {

/// Ranges larger than this factor use a logarithmic scale.
constexpr double kLogarithmic = 50;
const ImVec4 kChanged = {0.55f, 0.85f, 1.0f, 1.0f};

void Tooltip(const Parameter& p, const std::string& base_line) {
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
  facts += base_line;
  ImGui::TextDisabled("%s", facts.c_str());
  ImGui::PopTextWrapPos();
  ImGui::EndTooltip();
}

ImGuiSliderFlags SliderFlags(const Parameter& p) {
  const bool wide = p.min >= 0 && p.max - p.min > kLogarithmic * std::max(p.min, 1.0);
  return ImGuiSliderFlags_AlwaysClamp | (wide ? ImGuiSliderFlags_Logarithmic : 0);
}

bool FloatControl(const Parameter& p, std::string* value) {
  float number = std::stof(*value);
  const std::string format = *p.unit == '\0' ? "%.4g" : fmt::format("%.4g {}", p.unit);
  const bool changed =
      ImGui::SliderFloat("##value", &number, static_cast<float>(p.min), static_cast<float>(p.max),
                         format.c_str(), SliderFlags(p));
  *value = changed ? fmt::format("{}", number) : *value;
  return changed;
}

bool IntControl(const Parameter& p, std::string* value) {
  int number = std::stoi(*value);
  const std::string format = *p.unit == '\0' ? "%d" : fmt::format("%d {}", p.unit);
  const bool changed = ImGui::SliderInt("##value", &number, static_cast<int>(p.min),
                                        static_cast<int>(p.max), format.c_str(), SliderFlags(p));
  *value = changed ? fmt::format("{}", number) : *value;
  return changed;
}

bool FlagControl(std::string* value) {
  bool on = *value == "on";
  const bool changed = ImGui::Checkbox("##value", &on);
  *value = on ? "on" : "off";
  return changed;
}

bool ChoiceControl(const Parameter& p, std::string* value) {
  if (!ImGui::BeginCombo("##value", value->c_str())) {
    return false;
  }
  bool changed = false;
  for (const char* choice : p.choices) {
    if (ImGui::Selectable(choice, *value == choice)) {
      *value = choice;
      changed = true;
    }
  }
  ImGui::EndCombo();
  return changed;
}

bool Control(const Parameter& p, std::string* value) {
  switch (p.type) {
    case ParameterType::kFloat:
      return FloatControl(p, value);
    case ParameterType::kInt:
      return IntControl(p, value);
    case ParameterType::kFlag:
      return FlagControl(value);
    case ParameterType::kChoice:
      return ChoiceControl(p, value);
    case ParameterType::kSteps:
    case ParameterType::kSeed:
    case ParameterType::kText:
    case ParameterType::kRate:
      break;
  }
  return ImGui::InputText("##value", value, ImGuiInputTextFlags_EnterReturnsTrue);
}

void Name(const Parameter& p, bool changed) {
  ImGui::AlignTextToFramePadding();
  if (changed) {
    ImGui::PushStyleColor(ImGuiCol_Text, kChanged);
  }
  ImGui::TextUnformatted(p.name);
  if (changed) {
    ImGui::PopStyleColor();
  }
}

}  // namespace

std::optional<std::string> ParameterWidget(const Parameter& p, const std::string& value,
                                           const char* base_name, const std::string& base) {
  const std::string base_line = fmt::format("{}: {}", base_name, base);
  const bool differs = value != base;
  std::optional<std::string> result;
  ImGui::PushID(p.name);
  Name(p, differs);
  Tooltip(p, base_line);
  const float reset_width = ImGui::GetFrameHeight();
  ImGui::SameLine(ImGui::GetWindowContentRegionMax().x * 0.48f);
  ImGui::SetNextItemWidth(-(reset_width + ImGui::GetStyle().ItemInnerSpacing.x));
  std::string edited = value;
  if (Control(p, &edited)) {
    result = edited;
  }
  Tooltip(p, base_line);
  if (differs) {
    ImGui::SameLine(ImGui::GetWindowContentRegionMax().x - reset_width);
    if (ImGui::Button("x", {reset_width, 0})) {
      result = base;
    }
    if (ImGui::IsItemHovered()) {
      ImGui::SetTooltip("back to %s", base.c_str());
    }
  }
  ImGui::PopID();
  return result;
}

}  // namespace stillray::view
