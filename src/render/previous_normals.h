// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Guides::previous_normal of a finished frame on the host.
#pragma once

#include "render/scene_state.h"
#include "stillray/frame.h"

namespace stillray::render {

/// Sets the plane from the ids and normals of the frame; empty if no instance of the scene can
/// turn. A surface's normal in the last frame depends on its instance alone, so that no path needs
/// it.
void StorePreviousNormals(const SceneState& state, Frame* frame);

}  // namespace stillray::render
