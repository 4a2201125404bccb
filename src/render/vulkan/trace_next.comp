// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 460
#ifdef STILLRAY_HARDWARE
#extension GL_EXT_ray_tracing : require
#endif

// Finds the next hit of all active paths.
#include "render/vulkan/tracer.glsl"
#include "render/vulkan/rays.glsl"

void main() {
  uint next = 1u - batch.phase;
  uint place = ThreadNumber();
  if (place < queues[kQueueActive + next].count) {
    uint number = lists[ListStart(next) + place];
    hits[number] = FindFirstHit(rays[number]);
  }
}
