// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The motion of a camera that is known by its matrices.
#pragma once

#include <optional>

#include "io/camera_fit.h"
#include "stillray/aov.h"

namespace stillray::io {

/// The exact CameraMotion of perspective cameras.
/// \param width, height  of both pictures
/// \return nothing for other cameras, whose motion is not of this form, and for matrices without an
///     inverse
std::optional<CameraMotion> MotionOfCamera(const CameraMatrices& now, const CameraMatrices& before,
                                           int width, int height);

/// Whether MotionOfCamera applies to the camera.
bool HasPerspective(const CameraMatrices& camera, int width, int height);

}  // namespace stillray::io
