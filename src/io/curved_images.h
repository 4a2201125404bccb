// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Virtual guides (frame.h) of convex surfaces, from their shape alone. The virtual image in a
/// convex mirror lies behind its surface, at half its radius for distant objects, and nearer for
/// near objects (paraxial mirror equation, Born and Wolf, Principles of Optics, section 4.4.1). Its
/// depth is thus approximately known without the distance of the reflected object, and its motion
/// follows from the motion of the camera.
#pragma once

#include <optional>

#include "io/camera_fit.h"
#include "io/image_motion.h"
#include "stillray/frame.h"

namespace stillray::io {

/// Roughness of surfaces with such a virtual image, if the frame has no roughness. Their radiance
/// is reprojected by the image's motion (select_guides), but filtered by the guides of the surface.
inline constexpr float kCurvedRoughness = 0.3f;

/// Whether enough pixels, 0.2 %, show convex surfaces for SetCurvedImages to matter.
/// \param guides  depth and normal, and id if the surfaces have any
bool HasCurvedImages(const Guides& guides);

/// Adds depth and motion of the virtual image to frame->reflection (created if empty) where a
/// surface is convex and no virtual image is known: z + i cos(angle to the viewing axis), 1 / i = 2
/// c + 1 / d, with the largest principal curvature c, and the distance d of the surface from the
/// camera as an estimate of the distance of the reflected object. Where this estimate matters (2 c
/// d < 2) there is no image, and up to 4 the image is moved towards the surface. The motion is the
/// camera's at the image's depth. Surfaces with a known roughness below 0.1 are unchanged: their
/// images need guides of their own. A frame without roughness gets one: kCurvedRoughness on these
/// surfaces, else 0 at pixels with virtual images, 1 elsewhere.
/// \param fits    to the frame's guides
/// \param later   the motion of the images is left zero, as the caller sets it from the known
///     camera
/// \param frame   needs depth, normal and motion. Nothing is added if the motion does not fit a
///     camera in a mostly static scene, or if depth and normals fit no perspective
/// \param images  [in,out] the kinds of the images. `missing`, if it is kNone, is set if the frame
///     has convex surfaces and the camera's motion is unknown
void SetCurvedImages(CameraFits* fits, bool later, Frame* frame, FrameImages* images);

}  // namespace stillray::io
