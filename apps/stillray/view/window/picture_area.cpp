// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "view/window/picture_area.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <imgui.h>

#include "view/split.h"
#include "view/window/camera_input.h"
#include "view/window/readouts.h"

namespace stillray::view {
namespace {

constexpr float kGrab = 7;  // distance in pixels within which a divider can be dragged
constexpr ImU32 kLine = IM_COL32(240, 240, 240, 255);
constexpr ImU32 kShade = IM_COL32(0, 0, 0, 150);
constexpr ImU32 kText = IM_COL32(235, 238, 240, 255);

/// \param at  the lower left corner
/// \return its height
float DrawWrappedLabel(ImVec2 at, float width, const std::string& text) {
  ImDrawList* draw = ImGui::GetWindowDrawList();
  const ImVec2 size = ImGui::CalcTextSize(text.c_str(), nullptr, false, width);
  at.y -= size.y;
  draw->AddRectFilled({at.x - 5, at.y - 3}, {at.x + size.x + 5, at.y + size.y + 3}, kShade, 3);
  draw->AddText(ImGui::GetFont(), ImGui::GetFontSize(), at, kText, text.c_str(), nullptr, width);
  return size.y;
}

void DrawLabel(ImVec2 at, const std::string& text) {
  DrawWrappedLabel({at.x, at.y + ImGui::GetTextLineHeight()}, 0, text);
}

void DrawPanes(const Rect& area, const PaneTextures& textures, const ViewerState& state) {
  ImDrawList* draw = ImGui::GetWindowDrawList();
  const int count = textures.count();
  const std::vector<float> ends = PaneEnds(state.settings.dividers, count);
  float begin = 0;
  for (int i = 0; i < count; ++i) {
    const float end = ends[static_cast<size_t>(i)];
    const auto texture = reinterpret_cast<ImTextureID>(  // NOLINT: required by ImGui
        static_cast<uintptr_t>(textures.texture(i)));
    draw->AddImage(texture, {area.x + begin * area.width, area.y},
                   {area.x + end * area.width, area.y + area.height}, {begin, 0}, {end, 1});
    begin = end;
  }
  begin = 0;
  for (int i = 0; i < count; ++i) {
    const float left = area.x + begin * area.width;
    if (i > 0) {
      draw->AddLine({left, area.y}, {left, area.y + area.height}, kLine, 2);
      const float middle = area.y + area.height / 2;
      draw->AddRectFilled({left - 3, middle - 18}, {left + 3, middle + 18}, kLine, 3);
    }
    if (count > 1 || state.frame->panes[static_cast<size_t>(i)] != "denoised") {
      const Rect strip = {left, area.y, (ends[static_cast<size_t>(i)] - begin) * area.width, 0};
      draw->PushClipRect({strip.x, area.y}, {strip.x + strip.width, area.y + area.height}, true);
      DrawLabel({strip.x + 12, area.y + 10}, state.frame->panes[static_cast<size_t>(i)]);
      draw->PopClipRect();
    }
    const auto pane = static_cast<size_t>(i);
    if (pane < state.frame->ranges.size()) {
      DrawColourBar({left, area.y, (ends[pane] - begin) * area.width, area.height},
                    state.frame->ranges[pane]);
    }
    begin = ends[pane];
  }
}

/// The divider under the mouse; -1 if there is none.
int DividerAt(const Rect& area, float x, const ViewerState& state) {
  const std::vector<float> ends =
      PaneEnds(state.settings.dividers, static_cast<int>(state.settings.panes.size()));
  for (size_t i = 0; i + 1 < ends.size(); ++i) {
    if (std::abs(area.x + ends[i] * area.width - x) <= kGrab) {
      return static_cast<int>(i);
    }
  }
  return -1;
}

/// \return whether the mouse is used by a divider, and must not move the camera
bool HandleDividers(const Rect& area, ViewerState* state) {
  const ImGuiIO& io = ImGui::GetIO();
  const int under = ImGui::IsItemHovered() ? DividerAt(area, io.MousePos.x, *state) : -1;
  if (under >= 0 && ImGui::IsMouseClicked(ImGuiMouseButton_Left)) {
    state->dragged_divider = under;
  }
  if (!ImGui::IsMouseDown(ImGuiMouseButton_Left)) {
    state->dragged_divider = -1;
  }
  const bool held = state->dragged_divider >= 0 &&
                    state->dragged_divider + 1 < static_cast<int>(state->settings.panes.size());
  if (under >= 0 || held) {
    ImGui::SetMouseCursor(ImGuiMouseCursor_ResizeEW);
  }
  if (held) {
    std::vector<float> ends =
        PaneEnds(state->settings.dividers, static_cast<int>(state->settings.panes.size()));
    ends.pop_back();
    ends[static_cast<size_t>(state->dragged_divider)] = (io.MousePos.x - area.x) / area.width;
    state->settings.dividers = ends;
    state->changed = true;
  }
  return held;
}

void HandleInspector(const Rect& area, ViewerState* state) {
  if (!state->settings.inspect || state->inspector_pinned || !ImGui::IsItemHovered()) {
    return;
  }
  const ImVec2 mouse = ImGui::GetIO().MousePos;
  const float x = std::clamp((mouse.x - area.x) / area.width, 0.0f, 1.0f);
  const float y = std::clamp((mouse.y - area.y) / area.height, 0.0f, 1.0f);
  state->changed |= x != state->settings.inspect_x || y != state->settings.inspect_y;
  state->settings.inspect_x = x;
  state->settings.inspect_y = y;
}

void DrawInspectedPixel(const Rect& area, const ViewerState& state) {
  if (!state.settings.inspect || state.frame == nullptr) {
    return;
  }
  const auto w = static_cast<float>(state.frame->width);
  const auto h = static_cast<float>(state.frame->height);
  const float px = area.width / w;
  const float py = area.height / h;
  const float x = area.x + static_cast<float>(state.frame->inspect_x) * px;
  const float y = area.y + static_cast<float>(state.frame->inspect_y) * py;
  ImDrawList* draw = ImGui::GetWindowDrawList();
  draw->AddRect({x - 2, y - 2}, {x + px + 2, y + py + 2}, IM_COL32(0, 0, 0, 255));
  draw->AddRect({x - 1, y - 1}, {x + px + 1, y + py + 1}, IM_COL32(255, 255, 255, 255));
}

std::vector<std::string> StatusParts(const ViewerState& state) {
  const ViewFrame& f = *state.frame;
  std::vector<std::string> parts = {
      fmt::format("{}x{}", f.width, f.height),
      fmt::format("{} {} per pixel", ToText(f.rate), f.rate.value() > 1 ? "samples" : "sample"),
      fmt::format("{:.0f} ms", f.cost.total()),
      fmt::format("{:.1f} fps", state.times.FramesPerSecond())};
  if (f.fast_filter) {
    parts.emplace_back("moving: psvgf");
  }
  if (f.scale < f.chosen_scale * 0.99f) {
    parts.push_back(fmt::format("dynamic resolution {:.0f} %", f.scale * 100));
  }
  if (f.still && f.temporal && f.samples >= 1) {
    parts.push_back(fmt::format("{:.0f} spp accumulated", f.samples));
  }
  if (state.settings.reference && f.reference_spp > 0) {
    parts.push_back(fmt::format("reference {} spp", f.reference_spp));
  }
  return parts;
}

/// Draws the status, wrapped to the width of the image. \return y of its upper edge
float DrawStatus(const Rect& area, const ViewerState& state) {
  constexpr const char* kGap = "   ";
  std::vector<std::string> lines(1);
  for (const std::string& part : StatusParts(state)) {
    const std::string longer = lines.back().empty() ? part : lines.back() + kGap + part;
    if (lines.back().empty() || ImGui::CalcTextSize(longer.c_str()).x < area.width - 24) {
      lines.back() = longer;
    } else {
      lines.push_back(part);
    }
  }
  const float line = ImGui::GetTextLineHeight();
  float y = area.y + area.height - line - 10;
  for (auto text = lines.rbegin(); text != lines.rend(); ++text) {
    DrawLabel({area.x + 12, y}, *text);
    y -= line;
  }
  if (state.recording) {
    ImDrawList* draw = ImGui::GetWindowDrawList();
    draw->AddCircleFilled({area.x + area.width - 20, area.y + 20}, 7, IM_COL32(230, 50, 40, 255));
  }
  return y + line;
}

/// \param y  lower edge of the last toast
void DrawToasts(const Rect& area, float y, const ViewerState& state) {
  for (auto toast = state.toasts.rbegin(); toast != state.toasts.rend() && y > area.y; ++toast) {
    y -= DrawWrappedLabel({area.x + 12, y}, area.width - 24, toast->text) + 12;
  }
}

/// One bar per step: finished steps are full; the current one shows its progress, or a running mark
/// if unknown.
void DrawSteps(const Rect& bar, double now, const LoadPhase& phase) {
  constexpr float kGap = 4;
  constexpr ImU32 kEmpty = IM_COL32(60, 64, 70, 255);
  constexpr ImU32 kDone = IM_COL32(70, 170, 215, 255);
  ImDrawList* draw = ImGui::GetWindowDrawList();
  const float width = (bar.width + kGap) / static_cast<float>(phase.steps) - kGap;
  for (int i = 0; i < phase.steps; ++i) {
    const float x = bar.x + static_cast<float>(i) * (width + kGap);
    draw->AddRectFilled({x, bar.y}, {x + width, bar.y + bar.height}, kEmpty, 3);
    float begin = 0;
    float end = i < phase.step ? 1.0f : 0.0f;
    if (i == phase.step && phase.fraction >= 0) {
      end = std::clamp(static_cast<float>(phase.fraction), 0.0f, 1.0f);
    } else if (i == phase.step) {
      const auto at = static_cast<float>(std::fmod(now * 0.7, 1.0));
      begin = std::max(0.0f, at * 1.3f - 0.3f);
      end = std::min(1.0f, at * 1.3f);
    }
    draw->AddRectFilled({x + begin * width, bar.y}, {x + end * width, bar.y + bar.height}, kDone,
                        3);
  }
}

void DrawLoading(const Rect& area, double now, const ViewerState& state) {
  ImDrawList* draw = ImGui::GetWindowDrawList();
  const LoadPhase first_frame = {"tracing the first frame", 0, 1, -1};
  const LoadPhase& phase = state.load.loading ? state.load.phase : first_frame;
  const std::string text = state.load.loading
                               ? fmt::format("{} of {}: {} ... {:.1f} s", phase.step + 1,
                                             phase.steps, phase.what, state.load.seconds)
                               : phase.what;
  const ImVec2 size = ImGui::CalcTextSize(text.c_str());
  const float em = ImGui::GetFontSize();
  const float width = std::max(25 * em, size.x + 40);
  const float x = area.x + (area.width - width) / 2;
  const float y = area.y + area.height / 2 - 2.25f * em;
  draw->AddRectFilled({x, y}, {x + width, y + 4.5f * em}, IM_COL32(20, 22, 25, 235), 6);
  draw->AddText({x + (width - size.x) / 2, y + em}, kText, text.c_str());
  DrawSteps({x + 20, y + 3 * em, width - 40, 0.4f * em}, now, phase);
}

/// Marks the orbit centre after it has changed, and while the camera is dragged.
void DrawFocus(const Rect& area, double now, const ViewerState& state) {
  const ViewSettings& s = state.settings;
  const bool shown = now < state.focus_until || ImGui::IsItemActive();
  if (!shown || !s.free_camera || state.dragged_divider >= 0) {
    return;
  }
  const float per_unit = area.height / (2 * std::tan(s.pose.yfov / 2) * s.pose.distance);
  const ImVec2 at = {area.x + area.width / 2 + s.pose.aside.x * per_unit,
                     area.y + area.height / 2 - s.pose.aside.y * per_unit};
  ImDrawList* draw = ImGui::GetWindowDrawList();
  draw->AddCircle(at, 7, IM_COL32(0, 0, 0, 200), 20, 3.5f);
  draw->AddCircle(at, 7, IM_COL32(255, 210, 90, 255), 20, 1.5f);
  draw->AddCircleFilled(at, 1.5f, IM_COL32(255, 210, 90, 255));
}

}  // namespace

void DrawPictureArea(const Rect& area, const PaneTextures& textures, double now,
                     ViewerState* state) {
  ImGui::SetNextWindowPos({area.x, area.y});
  ImGui::SetNextWindowSize({area.width, area.height});
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {0, 0});
  constexpr ImGuiWindowFlags kBare =
      ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoSavedSettings |
      ImGuiWindowFlags_NoBackground | ImGuiWindowFlags_NoBringToFrontOnFocus |
      ImGuiWindowFlags_NoNav;
  ImGui::Begin("picture", nullptr, kBare);
  ImGui::PopStyleVar();
  ImGui::InvisibleButton("mouse", {area.width, area.height},
                         ImGuiButtonFlags_MouseButtonLeft | ImGuiButtonFlags_MouseButtonRight |
                             ImGuiButtonFlags_MouseButtonMiddle);
  HandleInspector(area, state);
  if (!HandleDividers(area, state)) {
    HandleCameraMouse(area, state);
  }
  float lowest = area.y + area.height - 12;
  if (state->frame != nullptr && textures.count() > 0) {
    DrawPanes(area, textures, *state);
    DrawInspectedPixel(area, *state);
    DrawFocus(area, now, *state);
    lowest = DrawStatus(area, *state) - 12;
    DrawInspectorBox(area, *state);
  }
  DrawToasts(area, lowest, *state);
  if (state->load.loading || (state->frame == nullptr && state->scene.number > 0)) {
    DrawLoading(area, now, *state);
  }
  ImGui::End();
}

}  // namespace stillray::view
