// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Loads and saves the viewer's settings.
#pragma once

#include <string>

#include "view/window/viewer_state.h"

namespace stillray::view {

/// \return errors of ReadSettingsFile; the state is then unchanged
Status LoadViewSettings(const std::string& path, ViewerState* state);
/// Writes the settings in the background; the engine reports the outcome.
void SaveViewSettings(const std::string& path, const ViewerState& state, ViewEngine* engine);

}  // namespace stillray::view
