// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450

// Runs between the steps: sets the indirect dispatch and launch sizes of the queues filled by a
// step, and clears the processed queues. If paths are unfinished after the last recorded step, it
// empties all queues, which disables later steps until the paths resume.
#include "render/vulkan/tracer.glsl"

layout(local_size_x = 1) in;

void SetCount(uint queue, uint count) {
  queues[queue].count = count;
  queues[queue].groups_x = (count + kGroupSize - 1u) / kGroupSize;
  queues[queue].groups_y = 1u;
  queues[queue].groups_z = 1u;
  queues[queue].rows = 1u;
  queues[queue].layers = 1u;
}

void CountStep() {
  progress.steps += 1u;
  counters.steps = max(counters.steps, progress.steps);
}

void Start() {
  uint count = queues[kQueueActive].count;
  SetCount(kQueueActive, count);
  SetCount(kQueueShadow, 0u);
  SetCount(kQueueShadow + 1u, 0u);
  progress.steps = 0u;
  if (count > 0u) {
    CountStep();
  }
}

// Runs between shading and the rays of a step. \param done the processed queue
void Step(uint done) {
  uint next = 1u - done;
  uint alive = queues[kQueueActive + next].count;
  uint seeking = queues[kQueueShadow + done].count;
  counters.bounce_rays += alive;
  counters.shadow_rays += seeking;
  if (alive > 0u) {
    CountStep();
  }
  if (batch.phase >= kPhaseMayStop) {
    if (batch.phase < kPhaseEnd && alive > 0u) {
      progress.left = alive;
      counters.left = alive;
    } else {
      counters.parts += 1u;
    }
    alive = 0u;
  }
  SetCount(kQueueActive + done, 0u);
  SetCount(kQueueActive + next, alive);
  SetCount(kQueueShadow + done, seeking);
  SetCount(kQueueShadow + next, 0u);
}

void main() {
  uint parity = batch.phase & 1u;
  if (batch.phase >= kPhaseResume) {
    SetCount(kQueueActive + parity, progress.left);
    progress.left = 0u;
  } else if (IsStopped()) {
    for (uint i = 0u; i < kQueueCount; ++i) {
      SetCount(i, 0u);
    }
  } else if (batch.phase == kPhaseStart) {
    Start();
  } else {
    Step(parity);
  }
}
