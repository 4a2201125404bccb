// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "view/window/widgets.h"

#include <string>

#include <imgui.h>

namespace stillray::view {
namespace {

constexpr float kNameShare = 0.42f;  // fraction of the line's width

std::string FormatWithUnit(const char* format, const char* unit) {
  return *unit == '\0' ? format : std::string(format) + " " + unit;
}

}  // namespace

void LabelFor(const char* name) {
  ImGui::AlignTextToFramePadding();
  ImGui::TextUnformatted(name);
  ImGui::SameLine(ImGui::GetWindowContentRegionMax().x * kNameShare);
  ImGui::SetNextItemWidth(-1);
}

void HelpMark(const char* text) {
  ImGui::SameLine();
  ImGui::TextDisabled("(?)");
  if (ImGui::IsItemHovered()) {
    ImGui::BeginTooltip();
    ImGui::PushTextWrapPos(ImGui::GetFontSize() * 26);
    ImGui::TextUnformatted(text);
    ImGui::PopTextWrapPos();
    ImGui::EndTooltip();
  }
}

bool LabelledSlider(const char* name, const char* unit, float* value, float min, float max,
                    const char* format) {
  LabelFor(name);
  const std::string id = std::string("##") + name;
  return ImGui::SliderFloat(id.c_str(), value, min, max, FormatWithUnit(format, unit).c_str(),
                            ImGuiSliderFlags_AlwaysClamp);
}

bool LabelledCombo(const char* name, int* chosen, const char* const* names, int count) {
  LabelFor(name);
  const std::string id = std::string("##") + name;
  return ImGui::Combo(id.c_str(), chosen, names, count);
}

}  // namespace stillray::view
