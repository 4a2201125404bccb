// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The motion of the camera from antialiased guides, with an error of hundredths of a pixel. Patch
/// matching underestimates motion by several per cent if guides are noisy. Guides of one sample per
/// pixel have jagged edges, which cause larger errors.
#pragma once

#include "io/camera_fit.h"
#include "motion/guide_pyramid.h"
#include "stillray/image.h"

namespace stillray::motion {

/// Refines the motion of a camera to minimise differences of albedo and normals on static surfaces:
/// robust least squares over the image, Gauss-Newton with the mean of both frames' gradients, which
/// converges quadratically (Benhimane and Malis 2004, Real-time image-based tracking of planes
/// using efficient second-order minimization). Results do not depend on the number of threads.
/// \param now     smoothed guides of this frame (GuidePyramid::levels)
/// \param before  smoothed guides of the previous frame, of the same size
/// \param depth   of this frame
/// \param start   initial motion, with an error of at most about one pixel
/// \return `start` if the guides have too little structure
CameraMotion AlignCamera(const GuideLevel& now, const GuideLevel& before, const Image1& depth,
                         const CameraMotion& start);

}  // namespace stillray::motion
