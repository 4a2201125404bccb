// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450

// The next hit of all paths that go on.
#include "render/vulkan/tracer.glsl"
#include "render/vulkan/traversal.glsl"

layout(local_size_x = 64) in;

void main() {
  uint next = 1u - batch.phase;
  if (gl_GlobalInvocationID.x < queues[kQueueActive + next].count) {
    uint number = lists[ListStart(next) + gl_GlobalInvocationID.x];
    hits[number] = FindFirstHit(rays[number]);
  }
}
