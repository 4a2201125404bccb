// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 460
#ifdef STILLRAY_HARDWARE
#extension GL_EXT_ray_tracing : require
#endif

// Traces the shadow rays of this step and adds the contributions of light sampling times their
// transmittance.
#include "render/vulkan/tracer.glsl"
#include "render/vulkan/rays.glsl"
#include "render/vulkan/pixel_light.glsl"

void main() {
  uint place = ThreadNumber();
  if (place < queues[kQueueShadow + batch.phase].count) {
    GpuShadow shadow = shadows[place];
    vec3 through = FindTransmittance(GpuRay(shadow.origin, shadow.end, shadow.direction, 0u));
    if (through != vec3(0.0f)) {
      AddFound(shadow.pixel, shadow.light, shadow.diffuse * through, shadow.specular * through);
    }
  }
}
