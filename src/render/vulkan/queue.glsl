// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Appending to queues and incrementing counters. Needs trace.glsl. With kAddByGroup one atomic
// serves a group of threads: hardware serialises atomics to one address. Without it there are no
// barriers, at each of which a software driver saves the state of all threads. The order within a
// queue may differ from run to run; the result of a pixel does not depend on it. Threads of a ray
// generation shader have no group; they only count.
#ifdef STILLRAY_HARDWARE
uint ToAdd(uint count) {
  return count;
}
#else
layout(constant_id = 0) const uint kAddByGroup = 1u;

shared uint group_count;
shared uint group_first;

// Called by all threads of the group. Returns the position for threads with `wanted`.
uint TakePlace(uint queue, bool wanted) {
  if (kAddByGroup == 0u) {
    return wanted ? atomicAdd(queues[queue].count, 1u) : 0u;
  }
  if (gl_LocalInvocationIndex == 0u) {
    group_count = 0u;
  }
  barrier();
  uint place = 0u;
  if (wanted) {
    place = atomicAdd(group_count, 1u);
  }
  barrier();
  if (gl_LocalInvocationIndex == 0u) {
    group_first = group_count == 0u ? 0u : atomicAdd(queues[queue].count, group_count);
  }
  barrier();
  return group_first + place;
}

// What the thread must add to a counter so that the counts of all threads are added. Called by all
// threads of the group.
uint ToAdd(uint count) {
  if (kAddByGroup == 0u) {
    return count;
  }
  barrier();
  if (gl_LocalInvocationIndex == 0u) {
    group_count = 0u;
  }
  barrier();
  if (count > 0u) {
    atomicAdd(group_count, count);
  }
  barrier();
  return gl_LocalInvocationIndex == 0u ? group_count : 0u;
}
#endif

// Called by all threads of the group.
void CountPrimaryRays(uint count) {
  uint added = ToAdd(count);
  if (added > 0u) {
    atomicAdd(counters.primary_rays, added);
  }
}

// Called by all threads of the group.
void CountBounceRays(uint count) {
  uint added = ToAdd(count);
  if (added > 0u) {
    atomicAdd(counters.bounce_rays, added);
  }
}

// Called by all threads of the group.
void CountImageRays(uint count) {
  uint added = ToAdd(count);
  if (added > 0u) {
    atomicAdd(counters.image_rays, added);
  }
}
