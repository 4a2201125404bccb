// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Virtual guides (frame.h) of convex surfaces, from their shape alone. A convex mirror shows the
/// world as a virtual image behind its surface, at half its radius if what is reflected is far
/// away, and nearer if it is near (paraxial mirror equation, Born and Wolf, Principles of Optics,
/// section 4.4.1). So the image's depth is nearly known without the distance of what is reflected,
/// and with the motion of the camera its motion is.
#pragma once

#include <optional>

#include "io/camera_fit.h"
#include "io/image_motion.h"
#include "stillray/frame.h"

namespace stillray::io {

/// Roughness of surfaces that show such an image, if the frame has none. Their light follows the
/// image's motion (select_guides), and keeps the guides of the surface.
inline constexpr float kCurvedRoughness = 0.3f;

/// Whether enough of the picture, 0.2 %, is convex for SetCurvedImages to matter.
/// \param guides  depth and normal, and id if the surfaces have any
bool HasCurvedImages(const Guides& guides);

/// Adds depth and motion of the image to frame->reflection, made if it is empty, where a surface
/// is convex and no reflected image is known: z + i cos(angle to the viewing axis), 1 / i = 2 c + 1
/// / d, with the largest principal curvature c and the distance d of the surface from the camera in
/// place of that of what is reflected. Where that guess matters (2 c d < 2) there is no image, and
/// up to 4 it is nearer to the surface. The motion is that of the camera at the image's depth.
/// Surfaces of a known roughness below 0.1 are left alone: such images have guides of their own.
/// If the frame has no roughness it gets one: kCurvedRoughness, else 0 where the frame shows
/// images, 1 elsewhere.
/// \param fits    to the frame's guides
/// \param later   the motion of the images is left zero, as the camera's is known otherwise
/// \param frame   needs depth, normal and motion. Nothing is added if the motion is not that of a
///     camera before a mostly static scene, or if depth and normals fit no perspective
/// \param images  [in,out] the kinds of the images. `missing`, if it is kNone, is set if the frame
///     has such surfaces and the camera's motion is unknown
void SetCurvedImages(CameraFits* fits, bool later, Frame* frame, FrameImages* images);

}  // namespace stillray::io
