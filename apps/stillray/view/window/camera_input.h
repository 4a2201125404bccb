// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Camera control by mouse and keys.
#pragma once

#include "view/window/layout.h"
#include "view/window/viewer_state.h"

namespace stillray::view {

/// Handles mouse input. Call it directly after the image widget, whose hover state is used.
void HandleCameraMouse(const Rect& area, ViewerState* state);
/// \param elapsed  seconds since the last call
/// \return whether a key that moves the camera is held down
bool HandleFlyKeys(double elapsed, ViewerState* state);

}  // namespace stillray::view
