// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/stages/edge_stopping_shared.h"
#include "denoise/vulkan/edge_exponent_shared.h"

// An epsilon so large that the depth weight is 1.
const float kWeightIsOff = 1e30f;

// Terms of the depth and normal weights that are common to the taps of a pixel.
struct TapGeometry {
  vec3 normal;
  float inverse_depth;
  float per_inverse_depth;
  vec2 gradient;        // of inverse depth, over the distance between taps
  float normal_scale;   // of the normal exponent: see NormalExponent2
  float plane_scale;    // see PlaneDepthExponent2
  vec2 slope;           // see GradientDepthExponent2: its change is slope . offset
  float slope_epsilon;  // and its epsilon
  vec2 ray;             // RayAt, for distances of positions
  float ray_of_offset;  // change of the ray over the distance between taps
};

// The kinds of weights, as function arguments, which are constants if known when the pipeline is
// made.
bool IsCurved(EdgeStopping edges) {
  return edges.curvature > 0.0f;
}
bool WeighsPlanes(EdgeStopping edges) {
  return edges.depth_weight_plane != 0;
}
bool WeighsPositions(EdgeStopping edges) {
  return edges.depth_weight_position != 0;
}

// p: the pixel; sigma_n: its exponent, CurvedSigmaN or the setting; distance: between taps, pixels
TapGeometry GeometryOf(EdgeStopping edges, bool curved, bool planes, bool positions, ivec2 p,
                       Surface s, Detail d, float sigma_n, float distance) {
  TapGeometry g;
  g.normal = s.normal;
  g.inverse_depth = s.inverse_depth;
  g.per_inverse_depth = 1.0f / s.inverse_depth;
  g.gradient = d.gradient * distance;
  g.normal_scale = NormalScale(sigma_n, curved);
  float steep = max(abs(d.gradient.x), abs(d.gradient.y)) * g.per_inverse_depth;
  bool off = edges.max_slope > 0.0f && steep > edges.max_slope;
  g.plane_scale = kExponentsOfE / edges.plane_tolerance * g.per_inverse_depth;
  g.slope = g.gradient * (edges.sigma_z / kExponentsOfE * g.per_inverse_depth);
  g.slope_epsilon = off ? kWeightIsOff : edges.depth_epsilon / kExponentsOfE;
  g.ray = positions ? RayAt(edges, vec2(p)) : vec2(0.0f);
  g.ray_of_offset = positions ? distance / edges.focal_pixels : 0.0f;
  return g;
}

// The inverse depth of the pixel's plane at an offset, in tap distances. The first sum is common to
// a row of taps.
float ExpectedAt(TapGeometry g, vec2 offset) {
  return (g.inverse_depth + g.gradient.y * offset.y) + g.gradient.x * offset.x;
}

// The negated exponent of 2 of the depth weight of another surface. offset: in tap distances
float DepthExponent2(EdgeStopping edges, bool planes, bool positions, TapGeometry g,
                     float inverse_depth, vec2 offset) {
  if (positions) {
    return kExponentsOfE * PositionExponent(g.inverse_depth, inverse_depth, g.ray,
                                            g.ray_of_offset * offset, edges.position_sigma);
  }
  if (planes) {
    return PlaneDepthExponent2(ExpectedAt(g, offset), inverse_depth, g.plane_scale);
  }
  float change = g.slope.y * offset.y + g.slope.x * offset.x;
  return GradientDepthExponent2(g.inverse_depth, inverse_depth, change, g.slope_epsilon);
}

// The exponent of 2 of the depth and normal weight of another surface.
float GeometryExponent2(EdgeStopping edges, bool curved, bool planes, bool positions, TapGeometry g,
                        vec3 normal, float inverse_depth, vec2 offset) {
  return NormalExponent2(dot(g.normal, normal), g.normal_scale, curved) -
         DepthExponent2(edges, planes, positions, g, inverse_depth, offset);
}
