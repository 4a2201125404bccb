// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "render/base_colour.h"

#include <algorithm>

namespace stillray::render {

bool FiltersTextures(const RenderSettings& settings, const Scene& scene) {
  return settings.filter_textures && settings.jitter &&
         std::any_of(scene.materials.begin(), scene.materials.end(),
                     [](const Material& m) { return m.base_color_texture.texture >= 0; });
}

PixelRays RaysBeside(const CameraView& view, vec2 point) {
  return {{view.position, view.Direction(point + vec2(kFootprintStep, 0.0f))},
          {view.position, view.Direction(point + vec2(0.0f, kFootprintStep))}};
}

bool HasMeanColour(const TraceContext& context, const Hit& hit) {
  const Material& material = *context.state.instance(hit.instance).material;
  return context.filters_textures && material.base_color_texture.texture >= 0;
}

vec3 BaseColourOf(const TraceContext& context, const Hit& hit, const PixelRays& rays, vec2 point) {
  if (!HasMeanColour(context, hit)) {
    return vec3(context.state.BaseColour(hit));
  }
  const Triangle t = context.state.TriangleOf(context.state.instance(hit.instance), hit.primitive);
  const vec3 place = t.p0 * (1.0f - hit.u - hit.v) + t.p1 * hit.u + t.p2 * hit.v;
  const Footprint footprint = MakeFootprint(t.p1 - t.p0, t.p2 - t.p0, place, rays.right, rays.down);
  return context.state.MeanBaseColour(hit, footprint, fract(point));
}

}  // namespace stillray::render
