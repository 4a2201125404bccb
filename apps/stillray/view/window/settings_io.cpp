// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "view/window/settings_io.h"

#include "common/settings_file.h"
#include "view/view_options.h"

namespace stillray::view {

Status LoadViewSettings(const std::string& path, ViewerState* state) {
  const Result<SettingsFile> file = ReadSettingsFile(path);
  if (!file.ok()) {
    return file.status();
  }
  ApplySettingsFile(file.value(), &state->settings);
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
  if (!s.auto_rate) {
    file.render.spp = ToText(s.rate);
  }
  file.render.guides = s.sparse_guides ? "sparse" : "full";
  file.render.bounces = s.bounces;
  file.render.sampler = s.sampler == SamplerKind::kSobol ? "sobol" : "halton16";
  file.render.regularise = s.regularise;
  engine->SaveFile(path, [path, file] { return WriteSettingsFile(path, file); });
}

}  // namespace stillray::view
