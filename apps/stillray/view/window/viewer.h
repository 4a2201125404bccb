// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The viewer's window: GLFW, Dear ImGui and OpenGL 3.3.
#pragma once

#include "stillray/status.h"
#include "view/view_options.h"

namespace stillray::view {

/// Shows the scene until the window is closed.
/// \return kUnsupported if there is no display or no OpenGL 3.3, or if this build has no viewer:
///     the message explains how to build one
Status RunViewer(const ViewOptions& options);

}  // namespace stillray::view
