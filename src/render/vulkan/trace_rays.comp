// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 460
#ifdef STILLRAY_HARDWARE
#extension GL_EXT_ray_tracing : require
#endif

// Traces a batch of rays: first hits or, with STILLRAY_SHADOW, transmittances.
#define STILLRAY_HARDWARE_SET 2
#include "render/vulkan/scene.glsl"
#include "render/vulkan/material_lookup.glsl"
#include "render/vulkan/rays.glsl"

layout(std430, set = 1, binding = 0) readonly buffer Rays {
  GpuRay rays[];
};
#ifdef STILLRAY_SHADOW
layout(std430, set = 1, binding = 1) writeonly buffer Lights {
  float lights[];  // 3 per ray
};
#else
layout(std430, set = 1, binding = 1) writeonly buffer Hits {
  GpuHit hits[];
};
#endif

layout(push_constant) uniform Push {
  uint count;
};

void main() {
  uint i = ThreadNumber();
  if (i >= count) {
    return;
  }
#ifdef STILLRAY_SHADOW
  vec3 light = FindTransmittance(rays[i]);
  lights[3u * i] = light.x;
  lights[3u * i + 1u] = light.y;
  lights[3u * i + 2u] = light.z;
#else
  hits[i] = FindFirstHit(rays[i]);
#endif
}
