// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "view/window/settings_io.h"

#include <string_view>

#include "common/settings_file.h"
#include "view/view_options.h"

namespace stillray::view {

Status LoadViewSettings(const std::string& path, ViewerState* state) {
  const Result<SettingsFile> file = ReadSettingsFile(path);
  if (!file.ok()) {
    return file.status();
  }
  STILLRAY_RETURN_IF_ERROR(ApplySettingsFile(file.value(), &state->settings));
  state->preset = file->preset;
  state->parameter_error.clear();
  state->changed = true;
  return Status::Ok();
}

void SaveViewSettings(const std::string& path, const ViewerState& state, ViewEngine* engine) {
  const ViewSettings& s = state.settings;
  SettingsFile file;
  file.preset = state.preset;
  file.denoise = s.denoise;
  for (const Parameter& p : RenderParameters()) {
    const bool is_rate = std::string_view(p.name) == "spp";
    if (is_rate && s.auto_rate) {
      continue;  // the momentary value of the adaptive rate
    }
    file.render.push_back(
        {p.name, is_rate ? ToText(s.rate) : GetRenderParameter(s.render, p.name).value()});
  }
  engine->SaveFile(path, [path, file] { return WriteSettingsFile(path, file); });
}

}  // namespace stillray::view
