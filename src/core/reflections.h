// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Reflections with known hit distance: the code common to CPU and devices.
#pragma once

#include "core/hit_distance_shared.h"
#include "stillray/camera.h"
#include "stillray/status.h"

namespace stillray {

/// \param width, height  of the frame
/// \return kInvalidArgument naming the camera that has no perspective or no inverse
Result<HitCamera> MakeHitCamera(const CameraMatrices& now, const CameraMatrices& before, int width,
                                int height);

}  // namespace stillray
