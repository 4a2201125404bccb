// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The local geometry of a hit, and the origins of rays that leave it.
#ifndef STILLRAY_RENDER_SHADING_POINT_SHARED_H
#define STILLRAY_RENDER_SHADING_POINT_SHARED_H

#ifdef __cplusplus
#include "render/bsdf_shared.h"
#include "render/geometry_shared.h"
#endif

STILLRAY_RENDER_BEGIN

struct ShadingPoint {
  vec3 position;
  vec3 geometric;    // geometric normal, unit length, towards the viewer
  LocalFrame frame;  // shading frame: z = shading normal, towards the viewer
  vec3 wo;           // unit direction towards the viewer
  vec3 local_wo;     // wo in `frame`; its z is at least kMinViewCosine
  int front;         // 1: the front face is hit
  int solid;         // 1: boundary of a solid; 0: an infinitely thin sheet
  // Transmittance of the solid over attenuation_distance.
  vec3 attenuation_colour;
  float attenuation_distance;
  vec3 multiscatter_colour;
  float scatter_anisotropy;
};

// Shading normals are bent towards the viewer to at least this cosine.
const float kMinViewCosine = 1e-3f;

// Whether geometric and shading normal agree on the side of wi; otherwise light would leak through
// the surface.
SHARED_FN bool IsConsistent(SHARED_IN(ShadingPoint) at, vec3 wi, float local_z) {
  return (dot(wi, at.geometric) > 0.0f) == (local_z > 0.0f);
}

// Whether the solid contains a scattering medium.
SHARED_FN bool Scatters(SHARED_IN(ShadingPoint) at) {
  return at.solid != 0 && at.attenuation_distance <= kLargestFloat &&
         dot(at.multiscatter_colour, vec3(1.0f) - at.attenuation_colour) > 0.0f;
}

// The offset origin of a ray that leaves in `direction`.
SHARED_FN vec3 OriginOf(SHARED_IN(ShadingPoint) at, vec3 direction) {
  bool up = dot(direction, at.geometric) > 0.0f;
  return OffsetPoint(at.position, up ? at.geometric : -at.geometric);
}

// The origin of a ray that continues behind a triangle at `point`; p0, p1, p2 in the vertex order
// of the mesh.
SHARED_FN vec3 OriginBehindTriangle(vec3 p0, vec3 p1, vec3 p2, vec3 point, vec3 direction) {
  vec3 normal = SafeNormalize(cross(p1 - p0, p2 - p0), direction);
  return OffsetPoint(point, dot(normal, direction) > 0.0f ? normal : -normal);
}

STILLRAY_RENDER_END

#endif  // STILLRAY_RENDER_SHADING_POINT_SHARED_H
