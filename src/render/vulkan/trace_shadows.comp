// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450

// Whether the light sought by this step arrives.
#include "render/vulkan/tracer.glsl"
#include "render/vulkan/traversal.glsl"
#include "render/vulkan/pixel_light.glsl"

layout(local_size_x = 64) in;

void main() {
  if (gl_GlobalInvocationID.x < queues[kQueueShadow + batch.phase].count) {
    GpuShadow shadow = shadows[gl_GlobalInvocationID.x];
    vec3 through = FindTransmittance(GpuRay(shadow.origin, shadow.end, shadow.direction, 0u));
    if (through != vec3(0.0f)) {
      AddFound(shadow.pixel, shadow.direct != 0, shadow.diffuse * through,
               shadow.specular * through);
    }
  }
}
