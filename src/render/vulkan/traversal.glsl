// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Traversal of the two-level BVH. Needs scene.glsl and material_lookup.glsl.
//
// Watertight: no ray passes between triangles that share an edge or a vertex (triangle_test.glsl),
// and none passes the box of one that it meets (box_test_shared.h).
#include "render/vulkan/box_test_shared.h"
#include "render/vulkan/triangle_test.glsl"

// Of two hits at the same distance the one with the smaller indices counts, so that the hit does
// not depend on the order of traversal.
bool Before(GpuHit a, GpuHit b) {
  if (a.t != b.t) {
    return a.t < b.t;
  }
  return a.instance != b.instance ? a.instance < b.instance : a.primitive < b.primitive;
}

// Distances are not negative: their bits have the same order.
void SwapIf(inout uvec2 a, inout uvec2 b) {
  uvec2 c = a;
  bool swap = a.x < b.x;
  a = swap ? b : a;
  b = swap ? c : b;
}

// The ray's first hit, or, for a shadow ray, the remaining light.
//
// One stack serves both levels: an entry is a pending child and the distance at which the ray
// enters it. Entering a placement pushes a mark, 0, at which the ray returns to the world.
GpuHit WalkScene(GpuRay ray, bool shadow, out vec3 light) {
  uvec2 stack[kStackSize];
  int depth = 0;
  Walk walk = MakeWalk(ray.origin, ray.direction);
  uint placed = kNoInstance;  // index of the placement
  uint instance = kNoInstance;
  GpuHit best = GpuHit(ray.end, 0.0f, 0.0f, kNoInstance, 0u);
  light = vec3(1.0f);
  uint node = 0u;
  bool walking = true;
  while (walking) {
    BvhNode inner = nodes[node];
    uvec4 enter = EnterChildren(inner, walk.origin, walk.inverse, best.t);
    uvec2 c0 = uvec2(enter.x, inner.children.x);
    uvec2 c1 = uvec2(enter.y, inner.children.y);
    uvec2 c2 = uvec2(enter.z, inner.children.z);
    uvec2 c3 = uvec2(enter.w, inner.children.w);
    // The nearest is last, to be popped first.
    SwapIf(c0, c1);
    SwapIf(c2, c3);
    SwapIf(c0, c2);
    SwapIf(c1, c3);
    SwapIf(c1, c2);
    if (c0.x != kMissed) {
      stack[depth++] = c0;
    }
    if (c1.x != kMissed) {
      stack[depth++] = c1;
    }
    if (c2.x != kMissed) {
      stack[depth++] = c2;
    }
    if (c3.x != kMissed) {
      stack[depth++] = c3;
    }
    walking = false;
    while (depth > 0 && !walking) {
      uvec2 entry = stack[--depth];
      uint child = entry.y;
      if (child == 0u) {
        walk = MakeWalk(ray.origin, ray.direction);
        placed = kNoInstance;
      } else if (uintBitsToFloat(entry.x) > best.t * kEndScale) {
        continue;
      } else if ((child & kLeafBit) == 0u) {
        node = child;
        walking = true;
      } else if (placed == kNoInstance) {
        placed = child & kLeafFirstMask;
        Placement placement = placements[placed];
        instance = placement.instance;
        if (instance != kNoInstance) {
          walk = WalkOf(ray, placement);
        }
        stack[depth++] = uvec2(0u);
        node = placement.root;
        walking = true;
      } else {
        uint first = child & kLeafFirstMask;
        uint last = first + (child >> kLeafCountShift & 7u);
        for (uint i = first; i <= last; ++i) {
          BvhTriangle triangle = triangles[i];
          vec3 tuv;
          if (!MeetTriangle(walk, triangle.p0, triangle.p1, triangle.p2, best.t, tuv)) {
            continue;
          }
          GpuHit hit = MakeHit(tuv, instance, triangle);
          if (!shadow) {
            if (Before(hit, best)) {
              best = hit;
            }
          } else {
            light *=
                triangle.see_through != 0u ? ShadowTransmittance(hit, ray.direction) : vec3(0.0f);
            if (light == vec3(0.0f)) {
              return hit;
            }
          }
        }
      }
    }
  }
  return best;
}

GpuHit FindFirstHit(GpuRay ray) {
  vec3 light;
  return WalkScene(ray, false, light);
}

// Transmittance from the ray's end to its origin, per channel in 0..1.
vec3 FindTransmittance(GpuRay ray) {
  vec3 light;
  WalkScene(ray, true, light);
  return light;
}
