// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Mouse and keys that move the camera.
#pragma once

#include "view/window/layout.h"
#include "view/window/viewer_state.h"

namespace stillray::view {

/// Call with the picture's widget as the last item, whose hover state is used.
void HandleCameraMouse(const Rect& area, ViewerState* state);
/// \param elapsed  seconds since the last call
/// \return whether a key that moves the camera is held down
bool HandleFlyKeys(double elapsed, ViewerState* state);

}  // namespace stillray::view
