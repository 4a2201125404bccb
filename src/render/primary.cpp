// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "render/primary.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace stillray::render {
namespace {

/// CameraView::Direction as one loop over arrays, which compilers vectorise.
void MakeCameraRays(const CameraView& camera, const vec2* points, int count, RayBatch* rays) {
  const CameraView view = camera;
  for (int i = 0; i < count; ++i) {
    const float x = (2.0f * points[i].x / view.width - 1.0f) * view.half_width;
    const float y = (1.0f - 2.0f * points[i].y / view.height) * view.half_height;
    const float dx = view.forward.x + view.right.x * x + view.up.x * y;
    const float dy = view.forward.y + view.right.y * x + view.up.y * y;
    const float dz = view.forward.z + view.right.z * x + view.up.z * y;
    const float scale = 1.0f / std::sqrt(dx * dx + dy * dy + dz * dz);
    rays->direction_x[i] = dx * scale;
    rays->direction_y[i] = dy * scale;
    rays->direction_z[i] = dz * scale;
  }
  std::fill_n(rays->origin_x, count, view.position.x);
  std::fill_n(rays->origin_y, count, view.position.y);
  std::fill_n(rays->origin_z, count, view.position.z);
  std::fill_n(rays->end, count, std::numeric_limits<float>::infinity());
  rays->count = count;
}

/// Primary rays through one point of the lens each.
void MakeLensRays(const CameraView& camera, const vec2* points, const vec2* lenses, int count,
                  RayBatch* rays) {
  rays->count = 0;
  for (int i = 0; i < count; ++i) {
    const CameraView view = camera.Through(lenses[i]);
    rays->Push(view.position, view.Direction(points[i]), kInfinity);
  }
}

/// Adds a layer to the pixel. Returns whether the ray continues behind it.
bool AddLayer(const Hit& hit, float opacity, PrimaryPixel* pixel) {
  if (!(opacity > 0.0f)) {
    return true;
  }
  const bool last = opacity >= 1.0f || pixel->count == kMaxLayers - 1;
  PrimaryLayer& layer = pixel->layers[pixel->count++];
  layer.hit = hit;
  layer.weight = last ? pixel->background : pixel->background * opacity;
  pixel->background = last ? 0.0f : pixel->background - layer.weight;
  return !last;
}

}  // namespace

vec3 OriginBehind(const SceneState& state, const Hit& hit, vec3 direction) {
  const Triangle t = state.TriangleOf(state.instance(hit.instance), hit.primitive);
  const vec3 point = t.p0 * (1.0f - hit.u - hit.v) + t.p1 * hit.u + t.p2 * hit.v;
  return OriginBehindTriangle(t.p0, t.p1, t.p2, point, direction);
}

void FindPrimarySurfaces(const TraceContext& context, const vec2* points, const vec2* lenses,
                         int count, RayScratch* scratch, PrimaryPixel* pixels,
                         RenderTimings* timings) {
  {
    const PhaseTimer timer(&timings->primary_ms);
    if (lenses != nullptr) {
      MakeLensRays(context.camera, points, lenses, count, &scratch->rays);
    } else {
      MakeCameraRays(context.camera, points, count, &scratch->rays);
    }
  }
  for (int pass = 0; pass < kMaxPasses && scratch->rays.count > 0; ++pass) {
    timings->primary_rays += static_cast<uint64_t>(scratch->rays.count);
    {
      const PhaseTimer timer(&timings->primary_ms);
      context.accel.IntersectCoherent(scratch->rays, &scratch->hits);
    }
    const PhaseTimer timer(&timings->shade_ms);
    if (pass == 0) {
      for (int i = 0; i < count; ++i) {
        pixels[i].point = points[i];
        pixels[i].direction = scratch->rays.Direction(i);
        pixels[i].lens = lenses != nullptr ? lenses[i] : vec2(0.0f);
        pixels[i].count = 0;
        pixels[i].background = 1.0f;  // the remaining weight
        scratch->owner[i] = i;
      }
    }
    const int traced = scratch->rays.count;
    scratch->rays.count = 0;
    for (int i = 0; i < traced; ++i) {
      const Hit hit = scratch->hits.Get(i);
      if (hit.instance == kNoHit) {
        continue;
      }
      const int owner = scratch->owner[i];
      PrimaryPixel* pixel = &pixels[owner];
      if (AddLayer(hit, context.state.Opacity(hit), pixel)) {
        // In place: rays written so far never outnumber rays read so far.
        scratch->owner[scratch->rays.count] = owner;
        scratch->rays.Push(OriginBehind(context.state, hit, pixel->direction), pixel->direction,
                           kInfinity);
      }
    }
  }
}

}  // namespace stillray::render
