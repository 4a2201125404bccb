// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Samples, resolution and light paths.
#include <vector>

#include <fmt/format.h>
#include <imgui.h>

#include "view/window/panels.h"
#include "view/window/widgets.h"

namespace stillray::view {
namespace {

void RateRow(ViewerState* state) {
  ViewSettings& s = state->settings;
  if (ImGui::Checkbox("Samples follow the frame time", &s.auto_rate)) {
    if (!s.auto_rate && state->frame != nullptr) {
      s.rate = state->frame->rate;
    }
    state->changed = true;
  }
  if (s.auto_rate) {
    auto target = static_cast<float>(s.target_ms);
    if (LabelledSlider("Frame time", "ms", &target, 10.0f, 500.0f, "%.0f")) {
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
  state->changed |= ImGui::Checkbox("It may fall for the frame time", &s.auto_scale);
  HelpMark(
      "Where even 1/256 samples per pixel take too long, the picture gets smaller, down to a "
      "quarter of this width and height, and larger again as soon as there is room.");
  if (state->frame != nullptr && state->frame->scale < state->frame->chosen_scale * 0.99f) {
    ImGui::TextColored({1.0f, 0.78f, 0.35f, 1.0f}, "now %.0f %%: larger frames take too long",
                       static_cast<double>(state->frame->scale * 100));
  }
}

}  // namespace

void DrawRenderPanel(ViewerState* state) {
  ViewSettings& s = state->settings;
  RateRow(state);
  ScaleRow(state);
  state->changed |= LabelledSlider("Bounces", "", &s.bounces, 1, 16);
  const char* kSamplers[] = {"sobol", "halton16"};
  int sampler = static_cast<int>(s.sampler);
  if (LabelledCombo("Sampler", &sampler, kSamplers, 2)) {
    s.sampler = static_cast<SamplerKind>(sampler);
    state->changed = true;
  }
  state->changed |= ImGui::Checkbox("Regularise paths", &s.regularise);
  HelpMark("Surfaces that a path meets after a rough one count as rougher: fewer fireflies.");
  state->changed |= ImGui::Checkbox("Sparse guides", &s.sparse_guides);
  HelpMark(
      "Below one sample per pixel: depth, normals and albedo are known only where a path was "
      "traced. Faster and coarser. Views of guides then show holes; filled.* shows what the filter "
      "makes of them.");
  if (ImGui::Button("Start anew")) {
    ++s.restart;
    state->changed = true;
  }
  HelpMark("Forgets all history (R).");
}

}  // namespace stillray::view
