// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Guides::previous_normal of a finished frame on the host.
#pragma once

#include "render/scene_state.h"
#include "stillray/frame.h"

namespace stillray::render {

/// The normal n of a surface that deforms, one frame ago.
vec3 PreviousNormalAt(const PlacedInstance& instance, const Hit& hit, vec3 n);

/// Makes the plane before the frame is traced; empty if no instance of the scene can turn.
void PreparePreviousNormals(const SceneState& state, Frame* frame);

/// Sets the plane from the ids and normals of the frame, except where an instance has changed its
/// shape: there tracing has stored them. The normal of all others depends on their instance alone,
/// so that no path needs it.
void StorePreviousNormals(const SceneState& state, Frame* frame);

}  // namespace stillray::render
