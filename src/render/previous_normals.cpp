// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "render/previous_normals.h"

#include "core/parallel.h"
#include "render/frame_store.h"
#include "render/previous_normal_shared.h"

namespace stillray::render {
namespace {

LinearRows RowsOf(const mat4& m) {
  return {vec3(m[0].x, m[1].x, m[2].x), vec3(m[0].y, m[1].y, m[2].y), vec3(m[0].z, m[1].z, m[2].z)};
}

SurfaceFrame FrameOf(const Mesh& mesh, const VertexArrays& vertices, const mat4& world,
                     const Hit& hit) {
  const uint32_t* corner = mesh.indices.data() + 3 * static_cast<size_t>(hit.primitive);
  const mat3 linear(world);
  const vec3* p = vertices.positions;
  const vec3* n = vertices.normals;
  const vec3 edge = linear * (p[corner[1]] - p[corner[0]]);
  const vec3 local =
      n[corner[0]] * (1.0f - hit.u - hit.v) + n[corner[1]] * hit.u + n[corner[2]] * hit.v;
  const mat3 cofactors = CofactorMatrix(linear);
  const float side = dot(linear[0], cofactors[0]) < 0.0f ? -1.0f : 1.0f;
  const vec3 flat = SafeNormalize(cross(edge, linear * (p[corner[2]] - p[corner[0]])), vec3(0.0f));
  return {SafeNormalize(cofactors * local * side, flat), edge};
}

}  // namespace

vec3 PreviousNormalAt(const PlacedInstance& instance, const Hit& hit, vec3 n) {
  return DeformedNormal(
      FrameOf(*instance.mesh, instance.vertices, instance.world, hit),
      FrameOf(*instance.mesh, instance.previous_vertices, instance.previous_world, hit), n);
}

void PreparePreviousNormals(const SceneState& state, Frame* frame) {
  Guides& g = frame->guides;
  if (state.may_turn()) {
    ResizeImage(&g.previous_normal, frame->width, frame->height);
  } else {
    g.previous_normal = Image3();
  }
}

void StorePreviousNormals(const SceneState& state, Frame* frame) {
  Guides& g = frame->guides;
  if (!state.may_turn()) {
    return;
  }
  ParallelRows(frame->height, 16, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      for (int x = 0; x < frame->width; ++x) {
        vec3 previous(0.0f);
        const uint32_t id = g.id(x, y);
        if (id != 0 && state.instance(id - 1).HasChangedShape()) {
          continue;
        }
        if (id != 0 && state.instance(id - 1).may_turn) {
          const PlacedInstance& instance = state.instance(id - 1);
          const vec3 normal(g.normal[0](x, y), g.normal[1](x, y), g.normal[2](x, y));
          previous =
              PreviousNormal(RowsOf(instance.world), RowsOf(instance.previous_world), normal);
        }
        StorePixel(&g.previous_normal, x, y, previous);
      }
    }
  });
}

}  // namespace stillray::render
