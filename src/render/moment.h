// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The cameras of a moment.
#pragma once

#include "render/lens.h"
#include "render/scene_state.h"
#include "stillray/render.h"

namespace stillray::render {

struct CameraPair {
  CameraView now;
  CameraView before;  ///< at the previous frame's moment
};

/// The camera of a pose, for a picture of this size in pixels: a pinhole without shift.
CameraView ViewOf(const CameraPose& pose, int width, int height);

/// \param state   at this moment
/// \param moment  checked (CheckMoment)
CameraPair CamerasOf(const SceneState& state, const RenderMoment& moment, int width, int height);

/// Sets the lenses of both cameras.
/// \param state  as given to CamerasOf
/// \param lens   of the moment's camera (LensOf)
void SetLens(const SceneState& state, const Lens& lens, CameraPair* cameras);

/// Whether any surface may transmit light by refraction.
bool AnyTransmission(const Scene& scene);

}  // namespace stillray::render
