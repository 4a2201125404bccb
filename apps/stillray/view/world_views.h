// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// World-space views, derived from a frame's guides and camera: surface positions, and object
/// motion without camera motion.
#pragma once

#include "stillray/frame.h"
#include "stillray/image.h"
#include "stillray/render.h"

namespace stillray::view {

struct WorldViews {
  Image3 position;       ///< surface position in world space; 0 without a surface
  Image2 object_motion;  ///< Guides::motion minus the motion caused by the camera
};

/// \param frame   with depth and motion, pixels in host memory; without them the planes are empty
/// \param pose           camera of the frame
/// \param previous_pose  camera of the previous frame
WorldViews MakeWorldViews(const Frame& frame, const CameraPose& pose,
                          const CameraPose& previous_pose);

}  // namespace stillray::view
