// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Virtual guides of the path tracer: guides of the surfaces reflected in smooth visible surfaces
/// (up to kMostReflectingRoughness) and refracted by glass. From the first surface, deterministic
/// specular chains, one starting with reflection and one with transmission, lead to the first rough
/// surface or to the sky. At later glass a chain follows the stronger of reflection and refraction.
/// Behind an alpha-blended surface, the virtual image is the later layer with the largest weight.
#pragma once

#include "render/primary.h"
#include "render/tiles.h"
#include "render/virtual_image_shared.h"
#include "stillray/frame.h"

namespace stillray::render {

/// The guides of a pixel's virtual image. See VirtualGuides.
struct VirtualImage {
  float depth = 0;  ///< 0: none
  vec3 normal;
  vec3 albedo;
  vec2 motion;
  uint32_t id = 0;
  float light = 0;  ///< luminance of an emitter or the sky seen by a single reflection
  /// The surface of the image and its mean base colour (BaseColourOf); no instance: none.
  Hit hit = Hit();
  vec3 base_colour = vec3(0.0f);
};

/// The kinds of virtual guides in a frame.
struct ImageKinds {
  bool reflection = false;
  /// Frame::refraction; transmitted light is then stored in separate signals.
  bool refraction = false;

  bool any() const { return reflection || refraction; }
  friend bool operator==(const ImageKinds&, const ImageKinds&) = default;
};

/// The virtual images that a scene may contain: reflections in smooth materials; transmission by
/// glass and alpha-blended surfaces.
ImageKinds ImagesOfScene(const Scene& scene);

/// The kinds in `of_scene` that frames store with these settings. None with a lens: the virtual
/// image of a single lens sample would not match the radiance averaged over all samples.
ImageKinds WantedImages(const RenderSettings& settings, const ImageKinds& of_scene, bool has_lens);

/// Resizes the planes of Frame::reflection and Frame::refraction, or empties them.
void PrepareVirtualGuides(const RenderSettings& settings, const ImageKinds& shown, Frame* frame);

/// The virtual images of a batch, by pixel.
struct ImageBatch {
  VirtualImage reflection[kBatchCapacity];
  VirtualImage refraction[kBatchCapacity];
};

/// \param shown      kinds of virtual images to compute
/// \param pixels     primary hits of a batch
/// \param first      first surfaces of pixels with a single layer
/// \param separates  per pixel, see TraceSample
/// \param images     [out] virtual images of the kinds in `shown`
void FindVirtualImages(const TraceContext& context, const ImageKinds& shown,
                       const PrimaryPixel* pixels, const FirstSurface* first, const bool* separates,
                       int count, RayScratch* scratch, ImageBatch* images, RenderTimings* timings);

/// The base colour at a vertex of one of the pixel's paths: at the surface of a virtual image that
/// of the image, by which its light is demodulated.
/// \param images  null: none
vec3 BaseColourOfVertex(const TraceContext& context, const ImageBatch* images, int pixel,
                        const Hit& hit);

/// Stores the virtual images of a tile's pixels, row by row.
void StoreVirtualImages(const Tile& tile, const VirtualImage* images, VirtualGuides* guides);

}  // namespace stillray::render
