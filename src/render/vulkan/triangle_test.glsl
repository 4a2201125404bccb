// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Ray/triangle intersection as in Woop, Benthin and Wald (2013), "Watertight Ray/Triangle
// Intersection". Where the paper falls back to double precision, this version counts zero as
// inside: both triangles of an edge are then hit, at equal distance. Needs scene.glsl.

// A ray in the space of a BVH, prepared for traversal.
struct Walk {
  vec3 origin;
  vec3 direction;
  vec3 inverse;
  ivec3 axes;  // permutation of the axes, right-handed; the last is the direction's dominant axis
  vec3 shear;
};

// Components of directions are clamped to at least this magnitude, so that 1/x and its products
// stay finite.
const float kLeastComponent = 1e-18f;

Walk MakeWalk(vec3 origin, vec3 direction) {
  Walk walk;
  walk.origin = origin;
  walk.direction = direction;
  vec3 side = mix(vec3(1.0f), vec3(-1.0f), lessThan(direction, vec3(0.0f)));
  walk.inverse = side / max(abs(direction), vec3(kLeastComponent));
  vec3 size = abs(direction);
  int z = size.x > size.y ? (size.x > size.z ? 0 : 2) : (size.y > size.z ? 1 : 2);
  int x = z == 2 ? 0 : z + 1;
  int y = x == 2 ? 0 : x + 1;
  // Preserves winding for directions along the negative axis.
  walk.axes = direction[z] < 0.0f ? ivec3(y, x, z) : ivec3(x, y, z);
  float scale = 1.0f / direction[z];
  walk.shear = vec3(direction[walk.axes.x] * scale, direction[walk.axes.y] * scale, scale);
  return walk;
}

// The ray in the space of a placement. The direction is not normalised, hence distances are in
// world units.
Walk WalkOf(GpuRay ray, Placement placement) {
  if (placement.instance == kNoInstance) {
    return MakeWalk(ray.origin, ray.direction);
  }
  return MakeWalk(TransformPoint(placement.to_object_x, placement.to_object_y,
                                 placement.to_object_z, ray.origin),
                  TransformVector(placement.to_object_x, placement.to_object_y,
                                  placement.to_object_z, ray.direction));
}

// Transforms p to ray space, where the ray starts at 0 and points along z. The operations are
// identical for all three corners, so that a corner shared by two triangles has one position.
vec3 ShearPoint(Walk walk, vec3 p) {
  precise vec3 q = p - walk.origin;
  precise float x = q[walk.axes.x] - walk.shear.x * q[walk.axes.z];
  precise float y = q[walk.axes.y] - walk.shear.y * q[walk.axes.z];
  precise float z = walk.shear.z * q[walk.axes.z];
  return vec3(x, y, z);
}

// Computes (t, u, v) of a hit; false if there is none at 0 < t <= end.
bool MeetTriangle(Walk walk, vec3 p0, vec3 p1, vec3 p2, float end, out vec3 tuv) {
  vec3 a = ShearPoint(walk, p0);
  vec3 b = ShearPoint(walk, p1);
  vec3 c = ShearPoint(walk, p2);
  // Products are rounded separately, so that swapping the ends of an edge exactly negates the
  // result.
  precise float cb = c.x * b.y;
  precise float bc = c.y * b.x;
  precise float ac = a.x * c.y;
  precise float ca = a.y * c.x;
  precise float ba = b.x * a.y;
  precise float ab = b.y * a.x;
  precise float u = cb - bc;
  precise float v = ac - ca;
  precise float w = ba - ab;
  tuv = vec3(0.0f);
  if ((u < 0.0f || v < 0.0f || w < 0.0f) && (u > 0.0f || v > 0.0f || w > 0.0f)) {
    return false;
  }
  float determinant = u + v + w;
  if (determinant == 0.0f) {
    return false;
  }
  float inverse = 1.0f / determinant;
  float t = (u * a.z + v * b.z + w * c.z) * inverse;
  tuv = vec3(t, v * inverse, w * inverse);
  return t > 0.0f && t <= end;
}

// \param instance  instance of the placement
GpuHit MakeHit(vec3 tuv, uint instance, BvhTriangle triangle) {
  return GpuHit(tuv.x, tuv.y, tuv.z, instance == kNoInstance ? triangle.instance : instance,
                triangle.primitive);
}
