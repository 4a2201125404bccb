// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The surfaces hit by the primary rays of a tile: a stack of layers per pixel, since alpha-blended
/// surfaces are partly transparent.
#pragma once

#include "render/primary_shared.h"
#include "render/trace_context.h"

namespace stillray::render {

struct PrimaryLayer {
  Hit hit;
  float weight = 0;  ///< coverage as a fraction of the pixel
};

/// The weights of a pixel's layers and its background sum to 1.
struct PrimaryPixel {
  vec2 point;  ///< image position of the ray in pixels
  vec3 direction;
  vec2 lens = vec2(0.0f);  ///< point of the aperture, in the unit disk
  int count = 0;
  float background = 0;
  PrimaryLayer layers[kMaxLayers];
};

/// The visible surface and BSDF of a pixel with a single layer.
struct FirstSurface {
  Surface surface;
  Bsdf bsdf;
};

/// Buffers for tracing one batch.
struct RayScratch {
  RayBatch rays;
  HitBatch hits;
  int owner[kBatchCapacity];  // pixel index of each ray
};

/// \param points  image positions of the primary rays in pixels; at most kBatchCapacity
/// \param lenses  points of the aperture (LensPoint), one per ray; null for a pinhole
/// \param pixels  [out] one per ray
void FindPrimarySurfaces(const TraceContext& context, const vec2* points, const vec2* lenses,
                         int count, RayScratch* scratch, PrimaryPixel* pixels,
                         RenderTimings* timings);

/// The pinhole camera at the pixel's point of the lens.
inline CameraView ViewOf(const CameraView& camera, const PrimaryPixel& pixel) {
  return camera.lens_radius > 0.0f ? camera.Through(pixel.lens) : camera;
}

/// The origin of a ray that continues behind the surface at `hit`.
vec3 OriginBehind(const SceneState& state, const Hit& hit, vec3 direction);

}  // namespace stillray::render
