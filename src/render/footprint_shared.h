// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The area of a triangle that a pixel covers, from ray differentials (Igehy 1999, "Tracing Ray
// Differentials"), as differences between a ray and the rays through two other points of its pixel;
// and the points of that area at which textures are sampled.
#ifndef STILLRAY_RENDER_FOOTPRINT_SHARED_H
#define STILLRAY_RENDER_FOOTPRINT_SHARED_H

#ifdef __cplusplus
#include "render/shared.h"
#endif

STILLRAY_RENDER_BEGIN

// Distance of the other rays from the ray of the pixel, in pixels.
const float kFootprintStep = 0.5f;
// Maximum number of texture samples along each axis of the pixel; fewer where it has fewer texels.
const int kMostTaps = 8;
// Largest change of a barycentric coordinate per pixel: larger ones are those of rays that graze
// the triangle's plane or miss it.
const float kLargestFootprint = 1e4f;

// A camera ray, or its continuation along a specular chain (virtual_image_shared.h).
struct ChainRay {
  vec3 origin;
  vec3 direction;  // unit length
};

// The rays through two other points of a pixel: kFootprintStep to the right, and below.
struct PixelRays {
  ChainRay right;
  ChainRay down;
};

// Change of the barycentric coordinates (u, v) of the triangle per pixel, to the right and
// downwards; zero if it is undefined.
struct Footprint {
  vec2 right;
  vec2 down;
};

SHARED_FN Footprint NoFootprint() {
  Footprint footprint;
  footprint.right = vec2(0.0f);
  footprint.down = vec2(0.0f);
  return footprint;
}

// Least squares coordinates of a vector in the basis of a triangle's edges.
SHARED_FN vec2 AlongEdges(vec3 edge_u, vec3 edge_v, vec3 offset) {
  float uu = dot(edge_u, edge_u);
  float uv = dot(edge_u, edge_v);
  float vv = dot(edge_v, edge_v);
  float u = dot(edge_u, offset);
  float v = dot(edge_v, offset);
  float scale = 1.0f / max(uu * vv - uv * uv, 1e-30f);
  return vec2(u * vv - v * uv, v * uu - u * uv) * scale;
}

// Barycentric coordinates, relative to those of `point`, at which a ray meets the triangle's plane;
// beyond kLargestFootprint if it does not.
SHARED_FN vec2 MeetPlane(vec3 edge_u, vec3 edge_v, vec3 point, SHARED_IN(ChainRay) ray) {
  vec3 plane = cross(edge_u, edge_v);
  float slope = dot(ray.direction, plane);
  float distance = dot(point - ray.origin, plane) / slope;
  if (!(distance > 0.0f && distance < kLargestFloat)) {
    return vec2(2.0f * kLargestFootprint);
  }
  return AlongEdges(edge_u, edge_v, ray.origin + ray.direction * distance - point);
}

// The footprint at the point where the pixel's ray meets the triangle.
// \param right, down  rays through the points kFootprintStep to the right and below
SHARED_FN Footprint MakeFootprint(vec3 edge_u, vec3 edge_v, vec3 point, SHARED_IN(ChainRay) right,
                                  SHARED_IN(ChainRay) down) {
  Footprint footprint;
  footprint.right = MeetPlane(edge_u, edge_v, point, right) / kFootprintStep;
  footprint.down = MeetPlane(edge_u, edge_v, point, down) / kFootprintStep;
  vec2 most = max(abs(footprint.right), abs(footprint.down));
  if (!(max(most.x, most.y) <= kLargestFootprint)) {
    return NoFootprint();
  }
  return footprint;
}

// Number of texture samples along one axis of the pixel: one for each texel.
// \param texels  change of the texture coordinates per pixel, in texels
SHARED_FN int TapsAlong(vec2 texels) {
  float count = sqrt(dot(texels, texels));
  return count < float(kMostTaps) ? max(int(ceil(count)), 1) : kMostTaps;
}

// Barycentric coordinates of texture sample (i, j) of counts.x times counts.y, evenly spread over
// the pixel.
// \param hit     barycentric coordinates of the ray
// \param within  position of the ray in its pixel, 0..1
SHARED_FN vec2 TapOf(SHARED_IN(Footprint) footprint, vec2 hit, vec2 within, int i, int j,
                     ivec2 counts) {
  vec2 offset =
      vec2((float(i) + 0.5f) / float(counts.x), (float(j) + 0.5f) / float(counts.y)) - within;
  return hit + footprint.right * offset.x + footprint.down * offset.y;
}

SHARED_FN bool IsInTriangle(vec2 barycentric) {
  return barycentric.x >= 0.0f && barycentric.y >= 0.0f && barycentric.x + barycentric.y <= 1.0f;
}

STILLRAY_RENDER_END

#endif  // STILLRAY_RENDER_FOOTPRINT_SHARED_H
