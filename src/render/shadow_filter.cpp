// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "render/shadow_filter.h"

#include "render/surface.h"

namespace stillray::render {

vec3 SceneShadowFilter::Transmittance(const Hit& hit, vec3 direction) const {
  const float opacity = state_.Opacity(hit);
  vec3 through(1.0f - opacity);
  const PlacedInstance& instance = state_.instance(hit.instance);
  if (opacity > 0.0f && instance.material->transmission > 0.0f && !instance.material->solid) {
    const Triangle t = state_.TriangleOf(instance, hit.primitive);
    const vec3 normal = SafeNormalize(cross(t.p1 - t.p0, t.p2 - t.p0), direction);
    through += opacity * SheetTransmittance(state_, hit, dot(normal, direction));
  }
  return through;
}

bool IsSeeThrough(const PlacedInstance& instance) {
  return !instance.opaque || (instance.material->transmission > 0.0f && !instance.material->solid);
}

std::vector<AccelInstance> DescribeInstances(const SceneState& state) {
  std::vector<AccelInstance> out(state.instances().size());
  for (size_t i = 0; i < out.size(); ++i) {
    const PlacedInstance& instance = state.instances()[i];
    out[i].instanced = instance.instanced;
    out[i].deforms = instance.deforms;
    out[i].placed = instance.placed;
    out[i].see_through = IsSeeThrough(instance);
  }
  return out;
}

}  // namespace stillray::render
