// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Traversal of the two-level BVH. Needs scene.glsl and material_lookup.glsl.
//
// Watertight: no ray passes between triangles that share an edge or a vertex (triangle_test.glsl),
// and no ray misses the box of a triangle that it intersects (box_test_shared.h).
#include "render/vulkan/box_test_shared.h"
#include "render/vulkan/child_group_shared.h"
#include "render/vulkan/triangle_test.glsl"

// Of two hits at equal distance the hit with the smaller indices is preferred, which makes the
// result independent of the traversal order.
bool Before(GpuHit a, GpuHit b) {
  if (a.t != b.t) {
    return a.t < b.t;
  }
  return a.instance != b.instance ? a.instance < b.instance : a.primitive < b.primitive;
}

// The ray's first hit or, for a shadow ray, its transmittance.
//
// Both levels share one stack: entries below `bottom` belong to the top level while the ray is in
// the space of a placement.
GpuHit WalkScene(GpuRay ray, bool shadow, out vec3 light) {
  ChildGroup stack[kStackSize];
  int depth = 0;
  int bottom = 0;
  Walk walk = MakeWalk(ray.origin, ray.direction);
  uint placed = kNoInstance;  // index of the placement
  uint instance = kNoInstance;
  GpuHit best = GpuHit(ray.end, 0.0f, 0.0f, kNoInstance, 0u);
  light = vec3(1.0f);
  uint node = 0u;
  while (true) {
    uint next;
    ChildGroup others =
        GroupChildren(node, EnterChildren(nodes[node], walk.origin, walk.inverse, best.t), next);
    bool inside = false;
    while (!inside) {
      if (next == kMissed) {
        if (depth > bottom) {
          others = stack[--depth];
          next = others.next;
          node = NodeOfGroup(others);
          others = WithoutNext(others);
        } else if (placed == kNoInstance) {
          return best;
        } else {
          walk = MakeWalk(ray.origin, ray.direction);
          placed = kNoInstance;
          bottom = 0;
          continue;
        }
      }
      if (DistanceOfChild(next) > best.t * kEndScale) {
        next = kMissed;  // the remaining children are not nearer
        continue;
      }
      uint child = nodes[node].children[NumberOfChild(next)];
      if ((child & kLeafBit) == 0u || placed == kNoInstance) {
        if (others.next != kMissed) {
          stack[depth++] = others;
        }
        inside = true;
        node = child;
        if ((child & kLeafBit) != 0u) {
          placed = child & kLeafFirstMask;
          bottom = depth;
          Placement placement = placements[placed];
          instance = placement.instance;
          if (instance != kNoInstance) {
            walk = WalkOf(ray, placement);
          }
          node = placement.root;
        }
        continue;
      }
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
      next = others.next;
      others = WithoutNext(others);
    }
  }
}

GpuHit FindFirstHit(GpuRay ray) {
  vec3 light;
  return WalkScene(ray, false, light);
}

// Transmittance between the ray's origin and end, per channel in 0..1.
vec3 FindTransmittance(GpuRay ray) {
  vec3 light;
  WalkScene(ray, true, light);
  return light;
}
