// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450

// One texture lookup of the tracer's per place.
#include "render/vulkan/scene.glsl"
#include "render/vulkan/material_lookup.glsl"
#include "textures_shared.h"

layout(local_size_x = 64) in;

layout(std430, set = 1, binding = 0) readonly buffer Lookups {
  TextureLookup lookups[];
};
layout(std430, set = 1, binding = 1) writeonly buffer Values {
  vec4 values[];
};

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i < uint(lookups.length())) {
    TextureLookup lookup = lookups[i];
    values[i] = SampleTexture(textures[lookup.texture_number], lookup.uv, lookup.srgb != 0u);
  }
}
