// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The visible surfaces of a tile's pixels: a stack per pixel, since alpha-blended ones are partly
/// transparent.
#pragma once

#include "render/primary_shared.h"
#include "render/trace_context.h"

namespace stillray::render {

struct PrimaryLayer {
  Hit hit;
  float weight = 0;  ///< fraction of the pixel
};

/// The weights of a pixel's layers and its background sum to 1.
struct PrimaryPixel {
  vec3 direction;
  vec2 lens = vec2(0.0f);  ///< point of the aperture, in the unit circle
  int count = 0;
  float background = 0;
  PrimaryLayer layers[kMaxLayers];
};

/// The visible surface of a pixel, if there is only one.
struct FirstSurface {
  Surface surface;
  Bsdf bsdf;
};

/// Buffers for tracing one batch.
struct RayScratch {
  RayBatch rays;
  HitBatch hits;
  int owner[kBatchCapacity];  // of each ray
};

/// \param points  positions of the rays in the picture, in pixels; at most kBatchCapacity
/// \param lenses  points of the aperture (LensPoint), one for each; null for a pinhole
/// \param pixels  [out] one for each
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
