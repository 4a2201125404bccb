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

// The exponent of the depth weight of another surface `offset` pixels away.
float DepthExponent(EdgeStopping edges, Surface s, Detail d, Surface other, vec2 offset) {
  return edges.depth_weight_plane != 0
             ? PlaneDepthExponent(s.inverse_depth, other.inverse_depth, d.gradient, offset,
                                  edges.plane_tolerance)
             : GradientDepthExponent(s.inverse_depth, other.inverse_depth, d.gradient, offset,
                                     edges.sigma_z, edges.depth_epsilon, edges.max_slope);
}

// The exponent of 2 of the depth and normal weight of another surface `offset` pixels away.
// sigma_n: see NormalExponent2
float GeometryExponent2(EdgeStopping edges, Surface s, Detail d, float sigma_n, Surface other,
                        vec2 offset) {
  float depth = DepthExponent(edges, s, d, other, offset);
  return NormalExponent2(dot(s.normal, other.normal), sigma_n, edges.curvature > 0.0f) -
         kExponentsOfE * depth;
}

// The depth and normal weight of another surface `offset` pixels away.
float GeometryWeight(EdgeStopping edges, Surface s, Detail d, float turn2, Surface other,
                     vec2 offset) {
  float depth = DepthExponent(edges, s, d, other, offset);
  return NormalWeightAt(edges, dot(s.normal, other.normal), turn2) * exp(-depth);
}
