// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The motion of the camera, exact to hundredths of a pixel, from antialiased guides. Motion that
/// is matched patch by patch is too short by several per cent where guides have noise. The edges of
/// guides of one sample per pixel are jagged, and mislead by more than that.
#pragma once

#include "io/camera_fit.h"
#include "motion/guide_pyramid.h"
#include "stillray/image.h"

namespace stillray::motion {

/// Improves the motion of a camera until colours and normals of still surfaces differ least:
/// robust least squares over the picture by Gauss and Newton, with the means of both frames'
/// gradients, whose steps converge by the second order (Benhimane and Malis 2004, Real-time
/// image-based tracking of planes using efficient second-order minimization).
/// The same bits for any number of threads.
/// \param now     smoothed guides of this frame (GuidePyramid::levels)
/// \param before  of the frame before, of the same size
/// \param depth   of this frame
/// \param start   right within about a pixel
/// \return `start` if the guides have too little structure
CameraMotion AlignCamera(const GuideLevel& now, const GuideLevel& before, const Image1& depth,
                         const CameraMotion& start);

}  // namespace stillray::motion
