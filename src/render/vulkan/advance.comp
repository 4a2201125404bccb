// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450

// Between the steps: sets the dispatches and launches of the queues that a step has filled, and
// clears the queues that have been processed.
#include "render/vulkan/tracer.glsl"

layout(local_size_x = 1) in;

void SetGroups(uint queue) {
  queues[queue].groups_x = (queues[queue].count + kGroupSize - 1u) / kGroupSize;
  queues[queue].groups_y = 1u;
  queues[queue].groups_z = 1u;
  queues[queue].rows = 1u;
  queues[queue].layers = 1u;
}

void main() {
  if (batch.phase == kPhaseReset) {
    for (uint i = 0u; i < kQueueCount; ++i) {
      queues[i].count = 0u;
    }
    return;
  }
  if (batch.phase == kPhaseStart) {
    SetGroups(kQueueActive);
    return;
  }
  uint done = batch.phase;
  uint next = 1u - done;
  SetGroups(kQueueActive + next);
  SetGroups(kQueueShadow + done);
  counters.bounce_rays += queues[kQueueActive + next].count;
  counters.shadow_rays += queues[kQueueShadow + done].count;
  queues[kQueueActive + done].count = 0u;
  queues[kQueueShadow + next].count = 0u;
}
