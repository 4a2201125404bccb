// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Settings of the viewer to and from files.
#pragma once

#include <string>

#include "view/window/viewer_state.h"

namespace stillray::view {

/// \return what ReadSettingsFile returns; the state is then unchanged
Status LoadViewSettings(const std::string& path, ViewerState* state);
Status SaveViewSettings(const std::string& path, const ViewerState& state);

}  // namespace stillray::view
