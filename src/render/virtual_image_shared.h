// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// How a ray passes smooth surfaces that are known around one point each: where an image in mirrors
// and glass was in the previous frame. Around its point a surface is its triangle's plane, with
// normals that change linearly, and the height that belongs to them: a quadric, as the vertices
// approximate it.
#ifndef STILLRAY_RENDER_VIRTUAL_IMAGE_SHARED_H
#define STILLRAY_RENDER_VIRTUAL_IMAGE_SHARED_H

#ifdef __cplusplus
#include "render/ggx_shared.h"
#endif

STILLRAY_RENDER_BEGIN

// A smooth surface around the point at which a chain of reflections and refractions meets it.
struct ChainVertex {
  vec3 position;
  vec3 edge_u;  // of the triangle
  vec3 edge_v;
  vec3 normal;    // shading normal, on the side of the arriving ray
  vec3 normal_u;  // its change along each edge
  vec3 normal_v;
  float eta;  // refractive index beyond over that before the surface; 0: the ray is reflected
};

struct ChainRay {
  vec3 origin;
  vec3 direction;  // unit length
};

// Coordinates of a vector in the triangle's plane along its edges; least squares.
SHARED_FN vec2 AlongEdges(SHARED_IN(ChainVertex) vertex, vec3 offset) {
  float uu = dot(vertex.edge_u, vertex.edge_u);
  float uv = dot(vertex.edge_u, vertex.edge_v);
  float vv = dot(vertex.edge_v, vertex.edge_v);
  float u = dot(vertex.edge_u, offset);
  float v = dot(vertex.edge_v, offset);
  float scale = 1.0f / max(uu * vv - uv * uv, 1e-30f);
  return vec2(u * vv - v * uv, v * uu - u * uv) * scale;
}

// The ray behind a vertex that the ray passes.
SHARED_FN ChainRay PassVertex(SHARED_IN(ChainVertex) vertex, ChainRay ray) {
  vec3 plane = normalize(cross(vertex.edge_u, vertex.edge_v));
  float slope = dot(ray.direction, plane);
  float along = abs(slope) > 1e-12f ? 1.0f / slope : 0.0f;
  vec3 point = ray.origin;
  vec3 change = vec3(0.0f);
  float height = 0.0f;
  // Each round inserts the height that belongs to the normals at the point of the last one.
  for (int i = 0; i < 3; ++i) {
    vec3 to_plane = vertex.position + plane * height - ray.origin;
    point = ray.origin + ray.direction * (dot(to_plane, plane) * along);
    vec3 offset = point - vertex.position;
    vec2 at = AlongEdges(vertex, offset);
    change = vertex.normal_u * at.x + vertex.normal_v * at.y;
    height = -0.5f * dot(change, offset) * (dot(vertex.normal, plane) < 0.0f ? -1.0f : 1.0f);
  }
  vec3 normal = normalize(vertex.normal + change);
  ChainRay next;
  next.origin = point;
  next.direction = vertex.eta > 0.0f ? RefractAbout(-ray.direction, normal, vertex.eta)
                                     : ray.direction - 2.0f * dot(ray.direction, normal) * normal;
  return next;
}

STILLRAY_RENDER_END

#endif  // STILLRAY_RENDER_VIRTUAL_IMAGE_SHARED_H
