// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// What the pixels of a tile see: a stack of surfaces, since alpha-blended ones let through.
#pragma once

#include "render/primary_shared.h"
#include "render/trace_context.h"

namespace stillray::render {

struct PrimaryLayer {
  Hit hit;
  float weight = 0;  ///< share of the pixel
};

/// Weights of a pixel's layers and its background add up to 1.
struct PrimaryPixel {
  vec3 direction;
  int count = 0;
  float background = 0;
  PrimaryLayer layers[kMaxLayers];
};

/// The surface that a pixel shows, where it is a single one.
struct FirstSurface {
  Surface surface;
  Bsdf bsdf;
};

/// Room for tracing one batch.
struct RayScratch {
  RayBatch rays;
  HitBatch hits;
  int owner[kBatchCapacity];  // of each ray
};

/// \param points  where the rays pass through the picture, in pixels; at most kBatchCapacity
/// \param pixels  [out] one for each
void FindPrimarySurfaces(const TraceContext& context, const vec2* points, int count,
                         RayScratch* scratch, PrimaryPixel* pixels, RenderTimings* timings);

/// Where a ray goes on that passes the surface at `hit`.
vec3 OriginBehind(const SceneState& state, const Hit& hit, vec3 direction);

}  // namespace stillray::render
