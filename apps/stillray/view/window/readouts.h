// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Values drawn over the image: colour scales, and the values of one pixel.
#pragma once

#include "view/window/layout.h"
#include "view/window/viewer_state.h"

namespace stillray::view {

/// Draws a pane's colour scale, with the values at its ends, in the pane's lower right corner.
void DrawColourBar(const Rect& pane, const ViewRange& range);
/// Draws the values of the inspected pixel in a box next to it, inside the area.
void DrawInspectorBox(const Rect& area, const ViewerState& state);
/// A number with four significant digits.
std::string NumberText(float value);

}  // namespace stillray::view
