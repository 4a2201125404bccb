// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Checks what the path tracer takes for granted about a scene: scenes may be built by hand.
#pragma once

#include "render/scene_state.h"
#include "stillray/render.h"

namespace stillray::render {

/// \return kInvalidArgument naming the element, what was found and what was expected
Status CheckScene(const Scene& scene);

/// \return kInvalidArgument naming the member, its value and its range
Status CheckMoment(const Scene& scene, const RenderMoment& moment);

/// Whether camera and instances stand where rays can be traced: an animation may take a node beyond
/// kMaxCoordinate that lies within it at the start.
/// \param state   at the moment
/// \param moment  checked (CheckMoment)
/// \return kInvalidArgument naming the node, the time and the limit
Status CheckPlaces(const SceneState& state, const RenderMoment& moment);

}  // namespace stillray::render
