// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Times, memory, metrics against the reference, and the values of one pixel.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <imgui.h>

#include "view/window/panels.h"
#include "view/window/readouts.h"
#include "view/window/widgets.h"

namespace stillray::view {
namespace {

constexpr ImU32 kTraceColour = IM_COL32(90, 165, 220, 255);
constexpr ImU32 kFilterColour = IM_COL32(235, 150, 70, 255);

void PlotTimes(const TimeHistory& times, double target_ms) {
  const ImVec2 at = ImGui::GetCursorScreenPos();
  const float width = ImGui::GetContentRegionAvail().x;
  const float plot_height = 4.7f * ImGui::GetFontSize();
  ImDrawList* draw = ImGui::GetWindowDrawList();
  draw->AddRectFilled(at, {at.x + width, at.y + plot_height}, IM_COL32(24, 26, 29, 255), 3);
  double top = target_ms * 1.5;
  for (int i = 0; i < times.count; ++i) {
    top = std::max(top, times.costs[static_cast<size_t>(i)].total());
  }
  const float step = width / TimeHistory::kLength;
  const auto y_of = [&](double ms) {
    return at.y + plot_height * (1 - static_cast<float>(ms / top));
  };
  for (int i = 0; i < times.count; ++i) {
    const int place = (times.next - times.count + i + TimeHistory::kLength) % TimeHistory::kLength;
    const FrameCost& cost = times.costs[static_cast<size_t>(place)];
    const float x = at.x + step * static_cast<float>(TimeHistory::kLength - times.count + i);
    const float middle = y_of(cost.trace_ms);
    draw->AddRectFilled({x, middle}, {x + step, at.y + plot_height}, kTraceColour);
    draw->AddRectFilled({x, y_of(cost.total())}, {x + step, middle}, kFilterColour);
  }
  const float line = y_of(target_ms);
  draw->AddLine({at.x, line}, {at.x + width, line}, IM_COL32(255, 255, 255, 110));
  draw->AddText({at.x + 5, at.y + 2}, IM_COL32(200, 205, 210, 255),
                fmt::format("{:.0f} ms", top).c_str());
  ImGui::Dummy({width, plot_height});
}

void ColouredTime(ImU32 colour, const char* name, double ms) {
  const ImVec2 at = ImGui::GetCursorScreenPos();
  const float size = ImGui::GetTextLineHeight() * 0.6f;
  ImGui::GetWindowDrawList()->AddRectFilled({at.x, at.y + size * 0.4f},
                                            {at.x + size, at.y + size * 1.4f}, colour);
  ImGui::SetCursorPosX(ImGui::GetCursorPosX() + size + 5);
  ImGui::Text("%s %.1f ms", name, ms);
}

void Row(const char* name, const std::string& value) {
  ImGui::TableNextRow();
  ImGui::TableNextColumn();
  ImGui::TextUnformatted(name);
  ImGui::TableNextColumn();
  const float room = ImGui::GetContentRegionAvail().x - ImGui::CalcTextSize(value.c_str()).x;
  ImGui::SetCursorPosX(ImGui::GetCursorPosX() + std::max(room, 0.0f));
  ImGui::TextUnformatted(value.c_str());
}

/// Shows name and value, on separate lines if both do not fit on one.
void WideRow(const char* name, const std::string& value) {
  ImGui::TableNextRow();
  ImGui::TableNextColumn();
  ImGui::TextUnformatted(name);
  const float needed = ImGui::CalcTextSize(value.c_str()).x;
  const float gap = 2 * ImGui::GetStyle().ItemSpacing.x;
  const float room = ImGui::GetContentRegionAvail().x;
  const bool fits = ImGui::CalcTextSize(name).x + gap + needed <= room;
  if (fits) {
    ImGui::SameLine();
  }
  ImGui::SetCursorPosX(ImGui::GetCursorPosX() +
                       std::max(ImGui::GetContentRegionAvail().x - needed, 0.0f));
  ImGui::TextUnformatted(value.c_str());
}

std::string Megabytes(size_t bytes) {
  return fmt::format("{:.1f} MB", static_cast<double>(bytes) / 1e6);
}

constexpr ImGuiTableFlags kTable = ImGuiTableFlags_RowBg | ImGuiTableFlags_SizingStretchProp;

void MeasureRow(const char* name, double noisy, double denoised, const char* format) {
  ImGui::TableNextRow();
  ImGui::TableNextColumn();
  ImGui::TextUnformatted(name);
  for (const double value : {noisy, denoised}) {
    ImGui::TableNextColumn();
    ImGui::Text(format, value);  // NOLINT: one of the formats below
  }
}

/// Shows how the finished image is transferred from a device to the window.
void TellPath(const ViewerState& state) {
  const ViewFrame& f = *state.frame;
  const auto shown = std::find(f.panes.begin(), f.panes.end(), "denoised");
  if (shown == f.panes.end() || f.device == "cpu") {
    return;
  }
  if (f.shared[static_cast<size_t>(shown - f.panes.begin())] != nullptr) {
    ImGui::TextWrapped("its picture stays on the device");
    return;
  }
  const char* why = state.recording                  ? "for the clip"
                    : state.unshared_because.empty() ? "the device shares no memory"
                                                     : state.unshared_because.c_str();
  ImGui::TextWrapped("its picture is copied: %s", why);
}

}  // namespace

void DrawTimePanel(const ViewerState& state) {
  if (state.frame == nullptr) {
    ImGui::TextDisabled("no frame yet");
    return;
  }
  const ViewFrame& f = *state.frame;
  PlotTimes(state.times, state.settings.target_ms);
  ColouredTime(kTraceColour, "tracing", f.cost.trace_ms);
  ImGui::SameLine();
  ColouredTime(kFilterColour, "filter", f.cost.filter_ms);
  if (f.tracer == f.device) {
    ImGui::TextWrapped("traced and filtered on %s", f.device.c_str());
  } else {
    ImGui::TextWrapped("traced on %s", f.tracer.c_str());
    ImGui::TextWrapped("filtered on %s", f.device.c_str());
  }
  TellPath(state);
  if (ImGui::BeginTable("stages", 2, kTable)) {
    for (const StageTime& stage : f.stages) {
      Row(std::string(stage.name).c_str(), fmt::format("{:.2f} ms", stage.milliseconds));
    }
    Row("memory: scene", Megabytes(f.memory.scene));
    Row("memory: denoiser", Megabytes(f.memory.denoiser));
    Row("memory: frame", Megabytes(f.memory.frame));
    ImGui::EndTable();
  }
}

void DrawMeasurePanel(ViewerState* state) {
  if (ImGui::Checkbox("Accumulate a reference", &state->settings.reference)) {
    state->changed = true;
  }
  HelpMark("While nothing moves, a converged picture is traced beside the frames.");
  if (state->frame == nullptr || !state->settings.reference) {
    return;
  }
  ImGui::Text("%d samples per pixel", state->frame->reference_spp);
  if (!state->frame->measures) {
    ImGui::TextDisabled("measured from 16 samples on, while nothing moves");
    return;
  }
  const LiveMeasures& m = *state->frame->measures;
  if (ImGui::BeginTable("measures", 3, kTable)) {
    ImGui::TableSetupColumn("");
    ImGui::TableSetupColumn("noisy");
    ImGui::TableSetupColumn("denoised");
    ImGui::TableHeadersRow();
    MeasureRow("PSNR, dB", m.noisy.psnr, m.denoised.psnr, "%.2f");
    MeasureRow("SSIM", m.noisy.ssim, m.denoised.ssim, "%.4f");
    MeasureRow("FLIP", m.noisy.flip, m.denoised.flip, "%.4f");
    MeasureRow("relMSE", m.noisy.rel_mse, m.denoised.rel_mse, "%.4g");
    MeasureRow("brightness", m.noisy.brightness, m.denoised.brightness, "%.4f");
    ImGui::EndTable();
  }
}

void DrawInspectorPanel(ViewerState* state) {
  state->changed |= ImGui::Checkbox("Inspect the pixel under the mouse", &state->settings.inspect);
  if (!state->settings.inspect) {
    return;
  }
  ImGui::Checkbox("Pinned", &state->inspector_pinned);
  HelpMark("I pins and releases the pixel; Shift + I ends it.");
  if (state->frame == nullptr || state->frame->inspected.empty()) {
    return;
  }
  ImGui::SameLine();
  ImGui::Text("pixel %d, %d", state->frame->inspect_x, state->frame->inspect_y);
  if (ImGui::BeginTable("pixel", 1, kTable)) {
    for (const InspectedValue& told : state->frame->inspected) {
      std::string text;
      for (const float value : told.values) {
        text += (text.empty() ? "" : "  ") + NumberText(value);
      }
      WideRow(told.view.c_str(), text);
    }
    ImGui::EndTable();
  }
}

}  // namespace stillray::view
