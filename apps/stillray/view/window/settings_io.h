// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Settings of the viewer to and from files.
#pragma once

#include <string>

#include "view/window/viewer_state.h"

namespace stillray::view {

/// \return what ReadSettingsFile returns; the state is then unchanged
Status LoadViewSettings(const std::string& path, ViewerState* state);
/// Written in the background; the engine tells how it went.
void SaveViewSettings(const std::string& path, const ViewerState& state, ViewEngine* engine);

}  // namespace stillray::view
