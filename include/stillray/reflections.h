// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Virtual guides of reflections from the length of reflected rays, as engines have it.
#pragma once

#include "stillray/camera.h"
#include "stillray/frame.h"
#include "stillray/status.h"

namespace stillray {

/// The images that mirrors show: each lies on the pixel's ray, as far away as the path to the
/// surface and the reflected ray together are long, and moves as a point of a still scene does that
/// is there. In planar mirrors that is exact for what stands still; on a curved surface the image
/// is nearer.
/// \param guides        needs depth. With roughness every pixel with a hit shows an image, and the
///     denoiser decides by roughness how it is used (virtual_roughness, virtual_motion_roughness).
///     Without it a pixel shows one if at least half of its neighbours on the same surface see what
///     it sees, at the same depth up to 3 %: the rays of rough surfaces are random. Normal and id,
///     where they are given, tell surfaces apart
/// \param hit_distance  length of the reflected ray from the first surface to what it met, in the
///     unit of depth; of the size of the depth. >= 1e9 and infinity: the sky. 0, negative, NaN: not
///     known, no image
/// \param now, before   perspective cameras of this frame and of the one before it, without jitter;
///     of the first frame, the same twice
/// \return depth and motion; normal, albedo and id are left empty, which are those of the mirror,
///     and white. kInvalidArgument if sizes differ, naming the image and both, or if a camera has
///     no perspective or no inverse
Result<VirtualGuides> ReflectionsFromHits(const Guides& guides, const Image1& hit_distance,
                                          const CameraMatrices& now, const CameraMatrices& before);

}  // namespace stillray
