// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Validates scenes, which callers may build themselves, for the path tracer.
#pragma once

#include "render/scene_state.h"
#include "stillray/render.h"

namespace stillray::render {

/// \return kInvalidArgument naming the element, the value found and the value expected
Status CheckScene(const Scene& scene);

/// \return kInvalidArgument naming the member, its value and its range
Status CheckMoment(const Scene& scene, const RenderMoment& moment);

/// Checks the coordinates of camera and instances: an animation may move a node beyond
/// kMaxCoordinate.
/// \param state   scene state at the moment
/// \param moment  checked (CheckMoment)
/// \return kInvalidArgument naming the node, the time and the limit
Status CheckPlaces(const SceneState& state, const RenderMoment& moment);

}  // namespace stillray::render
