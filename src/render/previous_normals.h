// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Guides::previous_normal of frames in host memory.
#pragma once

#include "render/scene_state.h"
#include "stillray/frame.h"

namespace stillray::render {

/// The previous-frame normal of n on a deforming surface.
vec3 PreviousNormalAt(const PlacedInstance& instance, const Hit& hit, vec3 n);

/// Allocates the plane before the frame is traced; empty if no instance of the scene can rotate.
void PreparePreviousNormals(const SceneState& state, Frame* frame);

/// Computes the plane from the ids and normals of the finished frame, except on instances whose
/// shape has changed: tracing has stored their normals. All other previous normals depend only on
/// the instance, so that tracing need not compute them.
void StorePreviousNormals(const SceneState& state, Frame* frame);

}  // namespace stillray::render
