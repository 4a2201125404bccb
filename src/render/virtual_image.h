// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Virtual guides of the tracer: what the visible smooth surfaces reflect, and what is seen through
/// them; surfaces up to kMostReflectingRoughness reflect an image too. From the first surface
/// deterministic chains of reflections and refractions lead to the first rough surface, or to the
/// sky: one begins by reflection, one by transmission. Where later
/// glass reflects and refracts, a chain takes the part with more light. Behind an alpha-blended
/// surface the heaviest of the next layers is seen.
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
  float light = 0;  ///< luminance of the light or sky that is seen by a single reflection
};

/// The virtual guides that frames have.
struct ImageKinds {
  bool reflection = false;
  /// Frame::refraction; transmitted light then has signals of its own.
  bool refraction = false;

  bool any() const { return reflection || refraction; }
  friend bool operator==(const ImageKinds&, const ImageKinds&) = default;
};

/// The images that a scene may show: reflections in smooth materials; what is seen through glass
/// and alpha-blended surfaces.
ImageKinds ImagesOfScene(const Scene& scene);

/// Those of them that frames get with these settings. None through a lens: the image that one of
/// the samples sees would be printed over the light of all.
ImageKinds WantedImages(const RenderSettings& settings, const ImageKinds& of_scene, bool has_lens);

/// Resizes the planes of Frame::reflection and Frame::refraction, or makes them empty.
void PrepareVirtualGuides(const RenderSettings& settings, const ImageKinds& shown, Frame* frame);

/// The images of a batch by pixel.
struct ImageBatch {
  VirtualImage reflection[kBatchCapacity];
  VirtualImage refraction[kBatchCapacity];
};

/// \param shown      kinds to find
/// \param pixels     of a batch
/// \param first      of pixels with a single layer
/// \param separates  by pixel, as for TraceSample
/// \param images     [out] of the kinds that are shown
void FindVirtualImages(const TraceContext& context, const ImageKinds& shown,
                       const PrimaryPixel* pixels, const FirstSurface* first, const bool* separates,
                       int count, RayScratch* scratch, ImageBatch* images, RenderTimings* timings);

/// Stores the images of a tile's pixels, row by row.
void StoreVirtualImages(const Tile& tile, const VirtualImage* images, VirtualGuides* guides);

}  // namespace stillray::render
