// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/stages/edge_stopping_shared.h"
#include "denoise/vulkan/edge_exponent_shared.h"

#include "denoise/stages/prepare_guides_shared.h"

float CosineTo(utexture2D surfaces, vec3 normal, ivec2 q) {
  return Inside(q) ? dot(normal, UnpackSurface(texelFetch(surfaces, q, 0)).normal) : 0.0f;
}

// SquaredTurn at p; 0 where the weights do not depend on it. Computed wherever it is used: the
// packed guides have no space left, and a level reads many more taps than these four.
float Turn2At(EdgeStopping edges, utexture2D surfaces, vec3 normal, ivec2 p) {
  return edges.curvature > 0.0f ? SquaredTurn(CosineTo(surfaces, normal, p - ivec2(1, 0)),
                                              CosineTo(surfaces, normal, p + ivec2(1, 0)),
                                              CosineTo(surfaces, normal, p - ivec2(0, 1)),
                                              CosineTo(surfaces, normal, p + ivec2(0, 1)))
                                : 0.0f;
}

// What the depth and normal weights of one pixel's taps share.
struct TapGeometry {
  vec3 normal;
  float inverse_depth;
  float per_inverse_depth;
  vec2 gradient;  // of the inverse depth, over the distance of taps
  float sigma_n;
  float depth_scale;    // of the depth exponent
  vec2 ray;             // RayAt, for distances of positions
  float ray_of_offset;  // change of the ray over the distance of taps
};

// The kinds of weights, as arguments: constants where they are known when the pipeline is made.
bool IsCurved(EdgeStopping edges) {
  return edges.curvature > 0.0f;
}
bool WeighsPlanes(EdgeStopping edges) {
  return edges.depth_weight_plane != 0;
}
bool WeighsPositions(EdgeStopping edges) {
  return edges.depth_weight_position != 0;
}

// p: the pixel; sigma_n: see NormalExponent2; distance: of taps, in pixels
TapGeometry GeometryOf(EdgeStopping edges, bool planes, bool positions, ivec2 p, Surface s,
                       Detail d, float sigma_n, float distance) {
  TapGeometry g;
  g.normal = s.normal;
  g.inverse_depth = s.inverse_depth;
  g.per_inverse_depth = 1.0f / s.inverse_depth;
  g.gradient = d.gradient * distance;
  g.sigma_n = sigma_n;
  float steep = max(abs(d.gradient.x), abs(d.gradient.y)) * g.per_inverse_depth;
  bool off = edges.max_slope > 0.0f && steep > edges.max_slope;
  g.depth_scale =
      planes ? kExponentsOfE / edges.plane_tolerance * g.per_inverse_depth : (off ? 0.0f : 1.0f);
  g.ray = positions ? RayAt(edges, vec2(p)) : vec2(0.0f);
  g.ray_of_offset = positions ? distance / edges.focal_pixels : 0.0f;
  return g;
}

// The exponent of 2 of the depth weight of another surface, negated. offset: in distances of taps
float DepthExponent2(EdgeStopping edges, bool planes, bool positions, TapGeometry g,
                     float inverse_depth, vec2 offset) {
  if (positions) {
    return kExponentsOfE * PositionExponent(g.inverse_depth, inverse_depth, g.ray,
                                            g.ray_of_offset * offset, edges.position_sigma);
  }
  float change = g.gradient.x * offset.x + g.gradient.y * offset.y;
  return planes ? PlaneDepthExponent2(g.inverse_depth + change, inverse_depth, g.depth_scale)
                : g.depth_scale * GradientDepthExponent2(g.inverse_depth, inverse_depth, change,
                                                         g.per_inverse_depth, edges.sigma_z,
                                                         edges.depth_epsilon);
}

// The exponent of 2 of the depth and normal weight of another surface.
float GeometryExponent2(EdgeStopping edges, bool curved, bool planes, bool positions, TapGeometry g,
                        vec3 normal, float inverse_depth, vec2 offset) {
  return NormalExponent2(dot(g.normal, normal), g.sigma_n, curved) -
         DepthExponent2(edges, planes, positions, g, inverse_depth, offset);
}
