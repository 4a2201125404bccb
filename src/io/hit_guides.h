// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Virtual guides (frame.h) of reflections from layers of hit distances.
#pragma once

#include <optional>

#include "io/camera_fit.h"
#include "io/image_motion.h"
#include "stillray/camera.h"
#include "stillray/frame.h"

namespace stillray::io {

/// Layers of what is reflected.
struct HitLayers {
  Image1 distance;  ///< as ConvertHitDistance returns it
  // As SeenLayers, each empty if it is not given. With `seen_depth` the others count only where its
  // path is as long as that of the reflection.
  Image1 seen_depth;
  Image3 seen_normal;
  Image3 seen_albedo;
};

/// The lens of a camera with square pixels. \return nothing without perspective
std::optional<Lens> LensOfCamera(const CameraMatrices& camera, int width, int height);
/// Of a centred camera. \param focal  pixels, > 0
Lens LensOfFocalLength(double focal, int width);

/// Sets frame->reflection, but for its motion (MoveSeenGuides), to the images that hit distances
/// place. Where the frame has a roughness, every pixel with a hit shows one, and the denoiser
/// decides by it (select_guides); else surfaces in which neighbours mostly see something else are
/// rough, and show none, as for SetSeenGuides.
/// \param lens    of the frame's depth
/// \param frame   needs depth and normal; its light distinguishes lamps
/// \param images  [out] kinds of reflections, and lens
void SetHitGuides(const HitLayers& layers, const Lens& lens, Frame* frame, FrameImages* images);

}  // namespace stillray::io
