// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/stages/edge_stopping_shared.h"

// The depth and normal weight of another surface `offset` pixels away.
float GeometryWeight(EdgeStopping edges, Surface s, Detail d, Surface other, vec2 offset) {
  float depth =
      edges.depth_weight_plane != 0
          ? PlaneDepthExponent(s.inverse_depth, other.inverse_depth, d.gradient, offset,
                               edges.plane_tolerance)
          : GradientDepthExponent(s.inverse_depth, other.inverse_depth, d.gradient, offset,
                                  edges.sigma_z, edges.depth_epsilon, edges.max_slope);
  return NormalWeight(dot(s.normal, other.normal), edges.sigma_n) * exp(-depth);
}
