// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "view/hit_views.h"

#include <algorithm>
#include <utility>

#include "core/parallel.h"
#include "render/moment.h"
#include "render/primary.h"

namespace stillray::view {
namespace {

constexpr float kOpaque = 0.5f;

/// Pixels of one row, and their rays without a hit so far.
struct RowPart {
  int y = 0;
  int x[render::kBatchCapacity];  ///< x coordinate of each ray's pixel
  render::RayBatch rays;
  render::HitBatch hits;
};

void Store(const render::SceneState& state, const render::Hit& hit, int x, int y, HitViews* views) {
  const float weights[3] = {1.0f - hit.u - hit.v, hit.u, hit.v};
  for (int c = 0; c < 3; ++c) {
    views->barycentrics[c](x, y) = weights[c];
  }
  views->triangle(x, y) = hit.primitive + 1;
  views->material(x, y) = static_cast<uint32_t>(state.instance(hit.instance).material_index) + 1;
}

/// Traces the rays until all have ended.
void FindSurfaces(const render::SceneState& state, const render::Accel& accel, RowPart* part,
                  HitViews* views) {
  for (int pass = 0; pass < render::kMaxPasses && part->rays.count > 0; ++pass) {
    accel.IntersectCoherent(part->rays, &part->hits);
    const int traced = std::exchange(part->rays.count, 0);
    for (int i = 0; i < traced; ++i) {
      const render::Hit hit = part->hits.Get(i);
      if (hit.instance == render::kNoHit) {
        continue;
      }
      if (state.Opacity(hit) >= kOpaque) {
        Store(state, hit, part->x[i], part->y, views);
        continue;
      }
      const vec3 direction = part->rays.Direction(i);
      part->x[part->rays.count] = part->x[i];  // in place: never overtakes the ray being read
      part->rays.Push(render::OriginBehind(state, hit, direction), direction, render::kInfinity);
    }
  }
  part->rays.count = 0;
}

}  // namespace

Result<std::unique_ptr<HitFinder>> HitFinder::Create(const Scene& scene) {
  std::unique_ptr<HitFinder> made(new HitFinder(scene));
  made->state_.Update(0.0, 0.0);
  Result<std::unique_ptr<render::Accel>> accel =
      render::Accel::Create(made->state_.scene(), render::DescribeInstances(made->state_),
                            made->state_.Places(), made->filter_);
  STILLRAY_RETURN_IF_ERROR(accel.status());
  made->accel_ = std::move(*accel);
  return made;
}

Result<HitViews> HitFinder::Find(const RenderMoment& moment, const Frame& frame) {
  if (state_.Update(moment.seconds, moment.previous_seconds)) {
    STILLRAY_RETURN_IF_ERROR(accel_->Update(state_.Places()));
  }
  const int width = frame.width;
  const int height = frame.height;
  const render::CameraView camera = render::CamerasOf(state_, moment, width, height).now;
  HitViews views = {Image3(width, height), Plane<uint32_t>(width, height),
                    Plane<uint32_t>(width, height)};
  ParallelRows(height, 1, [&](int y, int /*y1*/) {
    const auto part = std::make_unique<RowPart>();
    part->y = y;
    for (int x0 = 0; x0 < width; x0 += render::kBatchCapacity) {
      for (int x = x0; x < std::min(x0 + render::kBatchCapacity, width); ++x) {
        const vec2 point(static_cast<float>(x) + 0.5f + frame.jitter_x,
                         static_cast<float>(y) + 0.5f + frame.jitter_y);
        part->x[part->rays.count] = x;
        part->rays.Push(camera.position, camera.Direction(point), render::kInfinity);
      }
      FindSurfaces(state_, *accel_, part.get(), &views);
    }
  });
  return views;
}

}  // namespace stillray::view
