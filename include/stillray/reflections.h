// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Virtual guides of reflections from the hit distances of reflected rays.
#pragma once

#include "stillray/camera.h"
#include "stillray/frame.h"
#include "stillray/status.h"

namespace stillray {

/// Depth and motion of the virtual images in mirrors: a point on the pixel's ray, at the distance
/// of the camera ray plus the reflected ray, with the motion of a static point at that position.
/// Exact for static objects in planar mirrors; in a curved surface the true image is nearer.
/// \param guides        depth is required. With roughness every pixel with a hit gets a virtual
///     image, and the denoiser uses it by roughness (virtual_roughness, virtual_motion_roughness).
///     Without roughness a pixel gets a virtual image if at least half of its neighbours on the
///     same surface have an image within 3 % of its depth: the hits of rough surfaces are random.
///     Normal and id, if given, separate surfaces
/// \param hit_distance  length of the reflected ray from the first surface to its hit, in the unit
///     and the size of the depth. >= 1e9 and infinity: the sky. 0, negative, NaN: unknown, no
///     virtual image
/// \param now, before   perspective cameras of this and the previous frame, without jitter; in the
///     first frame, `before` equals `now`
/// \return depth and motion; normal and id are empty (those of the mirror), albedo is empty
///     (white). kInvalidArgument if sizes differ, naming the image and both sizes, or if a camera
///     has no perspective or no inverse
Result<VirtualGuides> ReflectionsFromHits(const Guides& guides, const Image1& hit_distance,
                                          const CameraMatrices& now, const CameraMatrices& before);

}  // namespace stillray
