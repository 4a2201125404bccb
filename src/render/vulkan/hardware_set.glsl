// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Ray payloads, and the bindings of the scene for ray tracing pipelines.
#ifndef STILLRAY_RENDER_VULKAN_HARDWARE_SET_GLSL
#define STILLRAY_RENDER_VULKAN_HARDWARE_SET_GLSL
#ifndef STILLRAY_HARDWARE_SET
#define STILLRAY_HARDWARE_SET 3
#endif

// For each bottom level, the indices of its opaque triangles, then of its see-through triangles.
layout(std430, set = STILLRAY_HARDWARE_SET, binding = 0) readonly buffer TriangleOrder {
  uint triangle_order[];
};
layout(set = STILLRAY_HARDWARE_SET, binding = 1) uniform accelerationStructureEXT top_level;

// A hit as reported by the ray tracing pipeline.
struct HardwareHit {
  vec3 tuv;
  uint placement;  // kNoInstance: none
  uint geometry;   // 0: opaque triangles of a bottom level, 1: see-through triangles
  uint primitive;
};

// Transmittance of a shadow ray, unless an opaque surface occludes it.
struct HardwareShadow {
  vec3 light;
  uint blocked;
};

// Recomputes the hit as in compute shaders, so that both ways of tracing yield equal frames. If
// that test misses by rounding, the pipeline's values are used.
GpuHit RefineHit(GpuRay ray, HardwareHit hit) {
  Placement placement = placements[hit.placement];
  uint number = triangle_order[placement.first_triangle +
                               hit.geometry * placement.opaque_triangles + hit.primitive];
  BvhTriangle triangle = triangles[number];
  vec3 exact;
  bool met =
      MeetTriangle(WalkOf(ray, placement), triangle.p0, triangle.p1, triangle.p2, ray.end, exact);
  return MakeHit(met ? exact : hit.tuv, placement.instance, triangle);
}
#endif
