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

/// Layers of the reflected surfaces.
struct HitLayers {
  Image1 distance;  ///< in the convention of ConvertHitDistance
  // As SeenLayers, each empty if not given. With `seen_depth` the other layers are used only where
  // its path length equals that of the reflection.
  Image1 seen_depth;
  Image3 seen_normal;
  Image3 seen_albedo;
};

/// The lens of a camera with square pixels. \return nothing without perspective
std::optional<Lens> LensOfCamera(const CameraMatrices& camera, int width, int height);
/// The lens of a centred camera. \param focal  pixels, > 0
Lens LensOfFocalLength(double focal, int width);

/// Sets frame->reflection, except for its motion (MoveSeenGuides), from hit distances. If the frame
/// has a roughness, every pixel with a hit gets a virtual image, and the denoiser uses it by
/// roughness (select_guides); else surfaces whose neighbouring pixels mostly have different hits
/// are rough, and get no virtual image, as in SetSeenGuides.
/// \param lens    of the frame's depth
/// \param frame   needs depth and normal; lamps are recognised by its radiance
/// \param images  [out] kinds of the virtual images, and lens
void SetHitGuides(const HitLayers& layers, const Lens& lens, Frame* frame, FrameImages* images);

}  // namespace stillray::io
