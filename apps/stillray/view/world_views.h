// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// World-space views, derived from a frame's guides and camera: positions of surfaces, and the
/// motion of objects without the camera's.
#pragma once

#include "stillray/frame.h"
#include "stillray/image.h"
#include "stillray/render.h"

namespace stillray::view {

struct WorldViews {
  Image3 position;       ///< of the surface, world space; 0 where there is none
  Image2 object_motion;  ///< Guides::motion minus that of a static surface, due to the camera
};

/// \param frame   with depth and motion, pixels in host memory; without them the planes are empty
/// \param pose           the camera of the frame
/// \param previous_pose  of the frame before
WorldViews MakeWorldViews(const Frame& frame, const CameraPose& pose,
                          const CameraPose& previous_pose);

}  // namespace stillray::view
