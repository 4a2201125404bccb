// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The lights, in descriptor set 1 of all tracer shaders. Needs render/shared.h, geometry_shared.h,
// ggx_shared.h and bsdf_shared.h.
#include "render/alias_shared.h"
#include "render/angles_shared.h"
#include "render/light_shapes_shared.h"
#include "render/punctual_shared.h"

layout(std140, set = 1, binding = 0) uniform LightsBlock {
  EnvironmentShape environment;
  LightShape lights;
};
layout(std430, set = 1, binding = 1) readonly buffer Entries {
  AliasEntry light_entries[];
};
layout(std430, set = 1, binding = 2) readonly buffer Areas {
  AreaLight area_lights[];
};
// Per instance: index of the area light of its triangle 0, or kNoArea.
layout(std430, set = 1, binding = 3) readonly buffer FirstAreas {
  uint first_areas[];
};
layout(std430, set = 1, binding = 4) readonly buffer Punctuals {
  PunctualSource punctual_sources[];
};
layout(std430, set = 1, binding = 5) readonly buffer EnvironmentSums {
  float environment_sums[];
};
layout(std430, set = 1, binding = 6) readonly buffer EnvironmentTexels {
  float environment_texels[];  // 3 each, row by row
};
const uint kNoArea = 0xffffffffu;

float EnvironmentSum(int i) {
  return environment_sums[i];
}
vec3 EnvironmentTexel(int x, int y) {
  int first = 3 * (y * environment.width + x);
  return vec3(environment_texels[first], environment_texels[first + 1],
              environment_texels[first + 2]);
}
AliasEntry LightEntry(uint i) {
  return light_entries[i];
}
AreaLight AreaLightAt(uint i) {
  return area_lights[i];
}
PunctualSource PunctualSourceAt(uint i) {
  return punctual_sources[i];
}

#include "render/environment_shared.h"
#include "render/lights_shared.h"
