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
  CameraView before;  ///< camera at the moment of the previous frame
};

/// The pinhole camera of a pose, without shift, for an image of width x height pixels.
CameraView ViewOf(const CameraPose& pose, int width, int height);

/// \param state   scene state at this moment
/// \param moment  checked (CheckMoment)
CameraPair CamerasOf(const SceneState& state, const RenderMoment& moment, int width, int height);

/// Sets the lenses of both cameras.
/// \param state  the argument of CamerasOf
/// \param lens   lens of the moment's camera (LensOf)
void SetLens(const SceneState& state, const Lens& lens, CameraPair* cameras);

/// Whether any surface may transmit light by refraction.
bool AnyTransmission(const Scene& scene);

}  // namespace stillray::render
