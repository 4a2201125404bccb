// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Appending to queues and incrementing counters. Needs trace.glsl. Each thread issues its own
// atomic, which drivers combine per subgroup. One atomic per workgroup, counted in shared memory,
// is no faster and needs barriers after the loops of a primary ray: NVIDIA's driver 580 let threads
// pass these too early, and paths were lost. The order within a queue may differ from run to run;
// the result of a pixel does not depend on the order.

// Appends an entry for threads with `wanted`, and returns its position.
uint TakePlace(uint queue, bool wanted) {
  return wanted ? atomicAdd(queues[queue].count, 1u) : 0u;
}

void CountPrimaryRays(uint count) {
  if (count > 0u) {
    atomicAdd(counters.primary_rays, count);
  }
}

void CountBounceRays(uint count) {
  if (count > 0u) {
    atomicAdd(counters.bounce_rays, count);
  }
}

void CountImageRays(uint count) {
  if (count > 0u) {
    atomicAdd(counters.image_rays, count);
  }
}
