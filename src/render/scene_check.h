// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Checks the path tracer's requirements on a scene, which callers may build themselves.
#pragma once

#include "render/scene_state.h"
#include "stillray/render.h"

namespace stillray::render {

/// \return kInvalidArgument naming the element, the value found and the value expected
Status CheckScene(const Scene& scene);

/// \return kInvalidArgument naming the member, its value and its range
Status CheckMoment(const Scene& scene, const RenderMoment& moment);

/// Checks that camera and instances are where rays can be traced: an animation may move a node
/// beyond kMaxCoordinate.
/// \param state   at the moment
/// \param moment  checked (CheckMoment)
/// \return kInvalidArgument naming the node, the time and the limit
Status CheckPlaces(const SceneState& state, const RenderMoment& moment);

}  // namespace stillray::render
