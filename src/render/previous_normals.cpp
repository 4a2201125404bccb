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

}  // namespace

void StorePreviousNormals(const SceneState& state, Frame* frame) {
  Guides& g = frame->guides;
  if (!state.may_turn()) {
    g.previous_normal = Image3();
    return;
  }
  ResizeImage(&g.previous_normal, frame->width, frame->height);
  ParallelRows(frame->height, 16, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      for (int x = 0; x < frame->width; ++x) {
        vec3 previous(0.0f);
        const uint32_t id = g.id(x, y);
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
