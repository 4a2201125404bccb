// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Virtual guides of the tracer: what the visible smooth surfaces reflect, or show by refraction.
/// From the first surface a deterministic chain of reflections and refractions leads to the first
/// rough surface, or to the sky. Where glass reflects and refracts, the chain takes the part with
/// more light.
#pragma once

#include "render/primary.h"
#include "render/tiles.h"
#include "render/virtual_image_shared.h"
#include "stillray/frame.h"

namespace stillray::render {

/// The image that a pixel shows. See VirtualGuides.
struct VirtualImage {
  float depth = 0;  ///< 0: none
  vec3 normal;
  vec3 albedo;
  vec2 motion;
  uint32_t id = 0;
};

/// Whether a scene has materials that may be smooth and show images.
bool MayShowImages(const Scene& scene);

/// Whether frames of a scene that may show images get virtual guides with these settings, unless
/// they are seen through a lens: the image that one of the samples sees would be printed over the
/// light of all.
bool WantsImages(const RenderSettings& settings);

/// Resizes the planes of Frame::reflection, or makes them empty; Frame::refraction is empty.
void PrepareVirtualGuides(const RenderSettings& settings, bool shown, Frame* frame);

/// \param pixels  of a batch
/// \param first   of pixels with a single layer
/// \param images  [out] one per pixel
void FindVirtualImages(const TraceContext& context, const PrimaryPixel* pixels,
                       const FirstSurface* first, int count, RayScratch* scratch,
                       VirtualImage* images, RenderTimings* timings);

/// Stores the images of a tile's pixels, row by row.
void StoreVirtualImages(const Tile& tile, const VirtualImage* images, VirtualGuides* guides);

}  // namespace stillray::render
