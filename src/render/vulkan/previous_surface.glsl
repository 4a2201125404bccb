// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The surface at a hit in the previous frame. Needs scene.glsl.
#include "render/previous_normal_shared.h"

// Whether the instance has neither moved nor deformed since the previous frame.
bool Stands(GpuInstance instance) {
  return !HasChangedShape(instance) && instance.world_x == instance.previous_x &&
         instance.world_y == instance.previous_y && instance.world_z == instance.previous_z;
}

// Interpolates a mesh's array of vec3.
vec3 Blend3(uint array, uvec3 corner, vec3 weight) {
  return Vec3At(array + 3u * corner.x) * weight.x + Vec3At(array + 3u * corner.y) * weight.y +
         Vec3At(array + 3u * corner.z) * weight.z;
}

// The position of a hit point in the previous frame.
// \param position  position in the current frame
vec3 PreviousPoint(GpuInstance instance, GpuHit hit, vec3 position) {
  if (Stands(instance)) {
    return position;
  }
  vec3 local =
      Blend3(instance.previous_positions, CornersOf(instance, hit.primitive), Weights(hit));
  return TransformPoint(instance.previous_x, instance.previous_y, instance.previous_z, local);
}

// FrameOf on the CPU; x, y and z are the rows of the object-to-world transform.
SurfaceFrame FrameOf(GpuInstance instance, GpuHit hit, uint positions, uint normals, vec3 x, vec3 y,
                     vec3 z) {
  uvec3 corner = CornersOf(instance, hit.primitive);
  vec3 p0 = Vec3At(positions + 3u * corner.x);
  vec3 edge_1 = Vec3At(positions + 3u * corner.y) - p0;
  vec3 edge_2 = Vec3At(positions + 3u * corner.z) - p0;
  SurfaceFrame f;
  f.edge = vec3(dot(x, edge_1), dot(y, edge_1), dot(z, edge_1));
  vec3 other = vec3(dot(x, edge_2), dot(y, edge_2), dot(z, edge_2));
  vec3 n = Blend3(normals, corner, Weights(hit));
  float side = dot(x, cross(y, z)) < 0.0f ? -1.0f : 1.0f;
  vec3 placed = side * vec3(dot(cross(y, z), n), dot(cross(z, x), n), dot(cross(x, y), n));
  f.normal = SafeNormalize(placed, SafeNormalize(cross(f.edge, other), vec3(0.0f)));
  return f;
}

// The previous-frame shading normal of a deformed instance.
vec3 PreviousNormalAt(GpuInstance i, GpuHit hit, vec3 n) {
  return DeformedNormal(
      FrameOf(i, hit, i.positions, i.normals, i.world_x.xyz, i.world_y.xyz, i.world_z.xyz),
      FrameOf(i, hit, i.previous_positions, i.previous_normals, i.previous_x.xyz, i.previous_y.xyz,
              i.previous_z.xyz),
      n);
}
