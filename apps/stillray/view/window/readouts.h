// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Values drawn over the picture: colour scales, and the values of one pixel.
#pragma once

#include "view/window/layout.h"
#include "view/window/viewer_state.h"

namespace stillray::view {

/// A bar with the colours of a pane and the values at its ends, in the pane's lower right corner.
void DrawColourBar(const Rect& pane, const ViewRange& range);
/// The values of the inspected pixel in a box beside it, inside the area.
void DrawInspectorBox(const Rect& area, const ViewerState& state);
/// A number in four significant digits.
std::string NumberText(float value);

}  // namespace stillray::view
