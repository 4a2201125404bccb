// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/stages/edge_stopping_shared.h"

// Weight of another surface `offset` pixels away by depth and normal.
float GeometryWeight(Surface s, Detail d, Surface other, vec2 offset) {
  float depth = plane != 0 ? PlaneDepthExponent(s.inverse_depth, other.inverse_depth, d.gradient,
                                                offset, plane_tolerance)
                           : GradientDepthExponent(s.inverse_depth, other.inverse_depth, d.gradient,
                                                   offset, sigma_z, depth_epsilon, max_slope);
  return NormalWeight(dot(s.normal, other.normal), sigma_n) * exp(-depth);
}
