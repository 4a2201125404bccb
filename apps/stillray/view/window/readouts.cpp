// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "view/window/readouts.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <imgui.h>

#include "view/colour_maps.h"

namespace stillray::view {
namespace {

constexpr ImU32 kShade = IM_COL32(14, 15, 17, 215);
constexpr ImU32 kName = IM_COL32(150, 158, 165, 255);
constexpr ImU32 kText = IM_COL32(235, 238, 240, 255);
constexpr int kBarSteps = 48;

ImU32 BarColour(const ViewRange& range, float at) {
  // Colour of motion to the right.
  const Rgb8 c = range.motion ? MotionColour(at, 0, 1) : Heat(at);
  return IM_COL32(c.r, c.g, c.b, 255);
}

/// The most important values of a pixel, in this order; the panel shows all values.
bool IsShort(const std::string& view) {
  static constexpr const char* kShown[] = {"denoised", "noisy",  "albedo", "depth",
                                           "normal",   "motion", "id"};
  const bool named = std::find(std::begin(kShown), std::end(kShown), view) != std::end(kShown);
  return named || view.starts_with("history.") || view.starts_with("variance.");
}

using Lines = std::vector<std::pair<std::string, std::string>>;

Lines LinesOf(const ViewFrame& frame) {
  Lines lines = {{"pixel", fmt::format("{}, {}", frame.inspect_x, frame.inspect_y)}};
  for (const InspectedValue& value : frame.inspected) {
    if (IsShort(value.view)) {
      std::string text;
      for (const float number : value.values) {
        text += (text.empty() ? "" : "  ") + NumberText(number);
      }
      lines.emplace_back(value.view, text);
    }
  }
  return lines;
}

float Width(const std::string& text) {
  return ImGui::CalcTextSize(text.c_str()).x;
}

}  // namespace

std::string NumberText(float value) {
  return std::isfinite(value) ? fmt::format("{:.4g}", value) : fmt::format("{}", value);
}

void DrawColourBar(const Rect& pane, const ViewRange& range) {
  const float em = ImGui::GetFontSize();
  const std::string high =
      fmt::format("{:.4g} {}{}", range.top, range.unit, range.logarithmic ? " (log)" : "");
  const float bar = 10 * em;
  const float low_width = Width("0");
  const float width = low_width + bar + Width(high) + 2.2f * em;
  if (range.top <= 0 || pane.width < width + em) {
    return;
  }
  ImDrawList* draw = ImGui::GetWindowDrawList();
  const float x = pane.x + pane.width - width - 0.6f * em;
  const float y = pane.y + pane.height - 4.2f * em;
  draw->AddRectFilled({x, y}, {x + width, y + 1.7f * em}, kShade, 3);
  const float text_y = y + 0.35f * em;
  draw->AddText({x + 0.6f * em, text_y}, kText, "0");
  const float left = x + low_width + 1.1f * em;
  const float step = bar / kBarSteps;
  for (int i = 0; i < kBarSteps; ++i) {
    const float at = (static_cast<float>(i) + 0.5f) / kBarSteps;
    const float from = left + step * static_cast<float>(i);
    draw->AddRectFilled({from, y + 0.45f * em}, {from + step + 0.5f, y + 1.25f * em},
                        BarColour(range, at));
  }
  draw->AddText({left + bar + 0.5f * em, text_y}, kText, high.c_str());
}

void DrawInspectorBox(const Rect& area, const ViewerState& state) {
  const ViewFrame& frame = *state.frame;
  if (!state.settings.inspect || frame.inspected.empty()) {
    return;
  }
  const float em = ImGui::GetFontSize();
  const float line = ImGui::GetTextLineHeightWithSpacing();
  const Lines lines = LinesOf(frame);
  float names = 0;
  float values = 0;
  for (const auto& [name, value] : lines) {
    names = std::max(names, Width(name));
    values = std::max(values, Width(value));
  }
  const float width = names + values + 2.2f * em;
  const float height = line * static_cast<float>(lines.size()) + 0.8f * em;
  const float pixel_x = area.x + area.width * (static_cast<float>(frame.inspect_x) + 0.5f) /
                                     static_cast<float>(frame.width);
  const float pixel_y = area.y + area.height * (static_cast<float>(frame.inspect_y) + 0.5f) /
                                     static_cast<float>(frame.height);
  const bool fits_right = pixel_x + 1.2f * em + width <= area.x + area.width;
  const float x = std::max(fits_right ? pixel_x + 1.2f * em : pixel_x - 1.2f * em - width, area.x);
  const float y = std::clamp(pixel_y + em, area.y, std::max(area.y + area.height - height, area.y));
  ImDrawList* draw = ImGui::GetWindowDrawList();
  draw->AddRectFilled({x, y}, {x + width, y + height}, kShade, 4);
  float at = y + 0.4f * em;
  for (const auto& [name, value] : lines) {
    draw->AddText({x + 0.6f * em, at}, kName, name.c_str());
    draw->AddText({x + names + 1.6f * em, at}, kText, value.c_str());
    at += line;
  }
}

}  // namespace stillray::view
