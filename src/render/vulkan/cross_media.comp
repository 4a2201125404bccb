// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450

// Advances active paths through scattering media to the surface where they leave or to their end:
// all collisions in one step, since a path may have hundreds. Rays in media always traverse
// stillray's BVH, even if ray tracing pipelines trace all other rays. The counterpart of
// Tracer::PassMedium on the CPU.
#include "render/vulkan/tracer.glsl"
#include "render/vulkan/rays.glsl"
#include "render/vulkan/queue.glsl"

// Returns the number of traced rays.
uint Cross(uint number, PathState path) {
  GpuRay ray = rays[number];
  GpuHit hit = hits[number];
  uint traced = 0u;
  int fate = kMediumScatters;
  while (true) {
    vec4 u = NumbersOf(path.seed, MediumDimensions(path.step));
    float roulette = NumbersOf(path.seed, LightDimensions(path.step)).w;
    vec3 direction = ray.direction;
    float distance = 0.0f;
    fate = CrossMedium(path, hit.t, u, roulette, frame.bounces, direction, distance);
    if (fate != kMediumScatters) {
      break;
    }
    path.step += 1;
    ray.origin += ray.direction * distance;
    ray.direction = direction;
    hit = FindFirstHit(ray);
    traced += 1u;
  }
  if (fate == kMediumEnds) {  // treated as a path that leaves the scene without contribution
    path.throughput = vec3(0.0f);
    hit.instance = kNoInstance;
  }
  StorePath(number, path, false);
  rays[number] = ray;
  hits[number] = hit;
  return traced;
}

void main() {
  uint next = 1u - batch.phase;
  uint place = ThreadNumber();
  uint traced = 0u;
  if (place < queues[kQueueActive + next].count) {
    uint number = lists[ListStart(next) + place];
    PathState path = LoadPath(number);
    if (IsInScatteringMedium(path)) {
      traced = Cross(number, path);
    }
  }
  CountBounceRays(traced);
}
