// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Edge-stopping weights of the wavelet and of the spatial variance estimate, as exponents of e: a
// product of weights is then one exponential.
#ifndef STILLRAY_DENOISE_EDGE_STOPPING_SHARED_H
#define STILLRAY_DENOISE_EDGE_STOPPING_SHARED_H

#ifdef __cplusplus
#include "core/shared.h"
#endif

SHARED_BEGIN

// Parameters of the edge-stopping functions, common to the stages that use them.
SHARED_BLOCK(EdgeStopping) {
  float sigma_n;           // exponent of the cosine between normals
  float curvature;         // see CurvedSigmaN; 0: off
  int depth_weight_plane;  // 1: depth by distance from the plane at p, 0: by the slope
  float sigma_z;
  float plane_tolerance;
  float depth_epsilon;
  float max_slope;
  int depth_weight_position;  // 1: by the distance between positions; depth_weight_plane is then 0
  float position_sigma;
  float focal_pixels;  // Frame::focal_pixels
  float centre_x;      // of the image, pixels
  float centre_y;
};

// Sums of weights of a level up to this count as zero: the pixel keeps its value.
const float kMinAtrousWeight = 1e-6f;

// max(0, n_p . n_q)^sigma_n: SVGF eq. 4, PSVGF section 4.4.1.
SHARED_FN float NormalWeight(float cosine, float sigma_n) {
  return pow(max(cosine, 0.0f), sigma_n);
}

// Lower bound of the exponent on curved surfaces: the weight is 1/2 at 24 degrees.
const float kLeastCurvedSigmaN = 8.0f;
// Lower bound for specular light (weight 1/2 at 12 degrees): a reflected ray turns by twice the
// angle of the normal, so that neighbours across a strong turn reflect other surfaces.
const float kLeastReflectedSigmaN = 32.0f;

// The exponent of the normal weight on a surface whose normal turns by sqrt(turn2) radians per
// pixel. With one exponent for all surfaces, pixels of small spheres, pipes and heads have few
// similar neighbours or none, and stay noisy.
// \param least  kLeastCurvedSigmaN or kLeastReflectedSigmaN
SHARED_FN float CurvedSigmaN(float sigma_n, float turn2, float curvature, float least) {
  return max(sigma_n / (1.0f + curvature * sigma_n * turn2), min(sigma_n, least));
}

// Natural logarithm of the cosine to second order about 1. The exponents on curved surfaces are so
// small that the error does not matter.
SHARED_FN float LogCosine(float cosine) {
  return cosine * (2.0f - 0.5f * cosine) - 1.5f;
}

// The normal weight of a neighbour of a pixel whose squared turn is `turn2`.
SHARED_FN float NormalWeightAt(EdgeStopping e, float cosine, float turn2, float least) {
  return e.curvature > 0.0f
             ? exp(CurvedSigmaN(e.sigma_n, turn2, e.curvature, least) * LogCosine(cosine))
             : NormalWeight(cosine, e.sigma_n);
}

// |z_p - z_q| / (sigma_z |grad z . (p - q)| + eps), eps in proportion to depth: SVGF eq. 3, PSVGF
// section 4.4.2. i is 1/z and g its gradient; grad z = -g z^2. Off (exponent 0) where the slope at
// p, relative to its depth and per pixel, exceeds max_slope (0: never off): a slope from so few
// pixels is not reliable.
SHARED_FN float GradientDepthExponent(float ip, float iq, vec2 g, vec2 offset, float sigma_z,
                                      float depth_epsilon, float max_slope) {
  float zp = 1.0f / ip;
  float zq = 1.0f / iq;
  float slope = abs(g.x * offset.x + g.y * offset.y) * zp * zp;
  float steep = max(abs(g.x), abs(g.y)) * zp;
  bool off = max_slope > 0.0f && steep > max_slope;
  return off ? 0.0f : abs(zp - zq) / (sigma_z * slope + depth_epsilon * zp);
}

// Distance of q from the plane through p along the ray of q, relative to depth, over the tolerance.
// On a plane inverse depth is affine in image coordinates, so this is exact for any slope.
SHARED_FN float PlaneDepthExponent(float ip, float iq, vec2 g, vec2 offset, float tolerance) {
  float expected = ip + g.x * offset.x + g.y * offset.y;
  return abs(expected - iq) / (tolerance * ip);
}

// View-space positions are enough, since distances do not depend on the camera's rotation: the
// position of pixel (x, y) at depth z is z (RayAt, 1).
SHARED_FN vec2 RayAt(EdgeStopping e, vec2 pixel) {
  return vec2(pixel.x + 0.5f - e.centre_x, pixel.y + 0.5f - e.centre_y) / e.focal_pixels;
}

// A negated exponent of e at which any weight is 0.
const float kNeverSimilar = 1e4f;

// |P_p - P_q|^2 / (sigma z_p)^2: Dammertz et al. 2010, section 3.2, with a tolerance in proportion
// to depth. ray: of p; offset: from the ray of p to that of q. The depths are subtracted before the
// division, so that the difference does not vanish in rounding at large depths.
SHARED_FN float PositionExponent(float ip, float iq, vec2 ray, vec2 offset, float sigma) {
  if (!(iq > 0.0f)) {
    return kNeverSimilar;
  }
  float deeper = (ip - iq) / iq;  // (z_q - z_p) / z_p
  vec2 across = deeper * ray + (deeper + 1.0f) * offset;
  return (dot(across, across) + deeper * deeper) / (sigma * sigma);
}

// The exponent of the depth weight that `e` selects. pixel: p; offset: from p to q
SHARED_FN float DepthExponent(EdgeStopping e, float ip, float iq, vec2 g, vec2 pixel, vec2 offset) {
  if (e.depth_weight_position != 0) {
    return PositionExponent(ip, iq, RayAt(e, pixel), offset / e.focal_pixels, e.position_sigma);
  }
  if (e.depth_weight_plane != 0) {
    return PlaneDepthExponent(ip, iq, g, offset, e.plane_tolerance);
  }
  return GradientDepthExponent(ip, iq, g, offset, e.sigma_z, e.depth_epsilon, e.max_slope);
}

// The reciprocal denominator of the luminance weight: log2(e) / (sigma_l sqrt(var_p) + eps), the
// factor of |l_p - l_q| in an exponent of 2 (SVGF eq. 5). `spread` is the root of the prefiltered
// variance (PSVGF: the variance itself); eps is `least` plus a term in proportion to the luminance.
SHARED_FN float LuminanceFactor(float l, float spread, float sigma_l, float epsilon, float least) {
  return 1.44269504f / (sigma_l * spread + epsilon * abs(l) + (least + 1e-12f));
}

// The reciprocal denominator for p and q: that of p, lowered to that of q but not below `least`.
SHARED_FN float LoweredLuminanceFactor(float factor_p, float factor_q, float least) {
  return min(factor_p, max(factor_q, least));
}

// The reciprocal denominator for p and q: that of p, as in the papers, lowered to that of a noisier
// q, but not below factor_p / ratio. The denominator of p alone darkens sparsely lit surfaces: the
// variance of a pixel with few bright samples is underestimated, so that brighter neighbours have
// little weight there, while the pixel has a large weight for them. Without the bound, noisy
// penumbras would leak into the clean surfaces beside them.
SHARED_FN float SharedLuminanceFactor(float factor_p, float factor_q, float ratio) {
  return LoweredLuminanceFactor(factor_p, factor_q, factor_p / ratio);
}

// Gaussians of Dammertz et al. 2010, section 3.2, with squared differences d2 over squared sigmas.
SHARED_FN float EawExponent(float luminance_d2, float normal_d2, float depth_d2, float sigma_l,
                            float sigma_n, float sigma_z) {
  return luminance_d2 / (sigma_l * sigma_l) + normal_d2 / (sigma_n * sigma_n) +
         depth_d2 / (sigma_z * sigma_z);
}

SHARED_END

#endif
