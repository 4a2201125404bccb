// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The point where a ray hits a surface, and the rays that leave it.
#ifndef STILLRAY_RENDER_SHADING_POINT_SHARED_H
#define STILLRAY_RENDER_SHADING_POINT_SHARED_H

#ifdef __cplusplus
#include "render/bsdf_shared.h"
#include "render/geometry_shared.h"
#endif

STILLRAY_RENDER_BEGIN

struct ShadingPoint {
  vec3 position;
  vec3 geometric;    // unit normal of the triangle, towards the viewer
  LocalFrame frame;  // z = the shading normal, towards the viewer too
  vec3 wo;           // unit, towards the viewer
  vec3 local_wo;     // wo in `frame`; its z is at least kMinViewCosine
  int front;         // 1: seen from the side of the triangle's normal
  int solid;         // 1: boundary of a solid; 0: an infinitely thin sheet
  // Of the solid: the transmittance over that distance.
  vec3 attenuation_colour;
  float attenuation_distance;
  vec3 multiscatter_colour;
  float scatter_anisotropy;
};

// Shading normals are bent towards the viewer to at least this cosine.
const float kMinViewCosine = 1e-3f;

// Whether wi is on the same side of the geometric and the shading normal; otherwise light would
// leak through the surface.
SHARED_FN bool IsConsistent(SHARED_IN(ShadingPoint) at, vec3 wi, float local_z) {
  return (dot(wi, at.geometric) > 0.0f) == (local_z > 0.0f);
}

// Whether light is scattered inside the solid.
SHARED_FN bool Scatters(SHARED_IN(ShadingPoint) at) {
  return at.solid != 0 && at.attenuation_distance <= kLargestFloat &&
         dot(at.multiscatter_colour, vec3(1.0f) - at.attenuation_colour) > 0.0f;
}

// The origin of the next ray.
SHARED_FN vec3 OriginOf(SHARED_IN(ShadingPoint) at, vec3 direction) {
  bool up = dot(direction, at.geometric) > 0.0f;
  return OffsetPoint(at.position, up ? at.geometric : -at.geometric);
}

// The origin of a ray that continues behind a triangle at `point`; corners as in the mesh.
SHARED_FN vec3 OriginBehindTriangle(vec3 p0, vec3 p1, vec3 p2, vec3 point, vec3 direction) {
  vec3 normal = SafeNormalize(cross(p1 - p0, p2 - p0), direction);
  return OffsetPoint(point, dot(normal, direction) > 0.0f ? normal : -normal);
}

STILLRAY_RENDER_END

#endif  // STILLRAY_RENDER_SHADING_POINT_SHARED_H
