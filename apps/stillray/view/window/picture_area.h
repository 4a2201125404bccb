// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The images side by side, with dividers, overlays, and mouse input.
#pragma once

#include "view/window/layout.h"
#include "view/window/pane_textures.h"
#include "view/window/viewer_state.h"

namespace stillray::view {

void DrawPictureArea(const Rect& area, const PaneTextures& textures, double now,
                     ViewerState* state);

}  // namespace stillray::view
