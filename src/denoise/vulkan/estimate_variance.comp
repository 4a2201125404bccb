// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require

// estimate_variance: see stages/estimate_variance.h. Writes the input of the wavelet (blended from
// the history before the last feedback and after it) and its deviation.
#include "denoise/vulkan/common.glsl"
#include "denoise/vulkan/edge_stopping.glsl"
#include "denoise/stages/estimate_variance_shared.h"

layout(set = 1, binding = 0) uniform utexture2D surface_image;
layout(set = 1, binding = 1) uniform utexture2D detail_image;
layout(set = 1, binding = 2) uniform texture2DArray noisy;
layout(set = 1, binding = 3) uniform texture2DArray colour;
layout(set = 1, binding = 4) uniform texture2DArray behind;
layout(set = 1, binding = 5) uniform texture2DArray moments;
layout(set = 1, binding = 6) uniform texture2DArray turn2_image;
layout(set = 1, binding = 7, LIGHT_FORMAT) writeonly uniform image2DArray light_out;

// Large enough that the luminance weight is 1: the largest half, independent of the unit of
// radiance.
float UnknownVariance(int s) {
#ifdef STILLRAY_HALF
  return VarianceOf(kMostLight);
#else
  return kUnknownVariance * exposure[s] * exposure[s];
#endif
}

const int kMostSide = 7;

// Sums over the second differences of a neighbourhood, whose rows are read in order.
struct SecondDifferences {
  float square;
  float weight;
};

void AddSecondDifference(vec3 l, vec3 w, inout SecondDifferences sums) {
  float d = l.x - 2.0f * l.y + l.z;
  float weight = w.x * w.y * w.z;
  sums.square += weight * d * d;
  sums.weight += weight;
}

// Variance of single samples from the neighbourhood on the same surface.
float SpatialVariance(Surface s, Detail detail, float mean, ivec3 at) {
  EdgeStopping edges = estimate_variance.edges;
  bool curved = IsCurved(edges);
  bool planes = WeighsPlanes(edges);
  bool positions = WeighsPositions(edges);
  float sigma_n = edges.sigma_n;
  if (curved) {
    float turn2 = texelFetch(turn2_image, ivec3(at.xy, 0), 0).x;
    sigma_n = CurvedSigmaN(edges.sigma_n, turn2, edges.curvature, kLeastCurvedSigmaN);
  }
  TapGeometry geometry =
      GeometryOf(edges, curved, planes, positions, at.xy, s, detail, sigma_n, 1.0f);
  float sum_weight = 0.0f;
  float sum_d = 0.0f;
  float sum_d2 = 0.0f;
  float sum_variance = 0.0f;
  SecondDifferences differences = SecondDifferences(0.0f, 0.0f);
  // Differences from `mean`, and weights, of the two rows before: y the previous row, x the one
  // before that.
  vec2 column_d[kMostSide];
  vec2 column_w[kMostSide];
  for (int i = 0; i < kMostSide; ++i) {
    column_d[i] = vec2(0.0f);
    column_w[i] = vec2(0.0f);
  }
  int radius = estimate_variance.short_history_radius;
  for (int dy = -radius; dy <= radius; ++dy) {
    vec2 row_d = vec2(0.0f);
    vec2 row_w = vec2(0.0f);
    for (int dx = -radius; dx <= radius; ++dx) {
      ivec2 q = at.xy + ivec2(dx, dy);
      float w = 0.0f;
      float d = 0.0f;
      if (Inside(q)) {
        vec4 m = texelFetch(moments, ivec3(q, at.z), 0);
        Surface other = UnpackSurface(texelFetch(surface_image, q, 0));
        if (m.z > 0.0f && other.inverse_depth > 0.0f) {
          w = exp2(GeometryExponent2(edges, curved, planes, positions, geometry, other.normal,
                                     other.inverse_depth, vec2(dx, dy)));
          d = m.x - mean;
          sum_weight += w;
          sum_d += w * d;
          sum_d2 += w * d * d;
          sum_variance += w * VarianceOf(m.y);
        }
      }
      int i = dx + radius;
      AddSecondDifference(vec3(row_d, d), vec3(row_w, w), differences);
      AddSecondDifference(vec3(column_d[i], d), vec3(column_w[i], w), differences);
      row_d = vec2(row_d.y, d);
      row_w = vec2(row_w.y, w);
      column_d[i] = vec2(column_d[i].y, d);
      column_w[i] = vec2(column_w[i].y, w);
    }
  }
  if (sum_weight < estimate_variance.least_evidence) {
    return UnknownVariance(at.z);
  }
  if (!(sum_weight > 0.0f)) {
    return 0.0f;
  }
  float mean_d = sum_d / sum_weight;
  float between = max(sum_d2 / sum_weight - mean_d * mean_d, 0.0f);
  if (estimate_variance.short_history == kShortHistorySecondDifference) {
    between = SecondDifferenceVariance(differences.square, differences.weight, between);
  }
  return between + sum_variance / sum_weight;
}

void main() {
  ivec2 p = ivec2(gl_GlobalInvocationID.xy);
  if (!Inside(p)) {
    return;
  }
  Surface surface = UnpackSurface(texelFetch(surface_image, p, 0));
  Detail detail = UnpackDetail(texelFetch(detail_image, p, 0), surface.inverse_depth);
  for (int s = 0; s < SignalCount(); ++s) {
    ivec3 at = ivec3(p, s);
    vec4 m = texelFetch(moments, at, 0);
    bool valid = surface.inverse_depth > 0.0f && m.z > 0.0f;
    float samples = max(texelFetch(noisy, at, 0).w, 1.0f);
    float variance = 0.0f;
    if (estimates_variance == 0 || !valid) {
      variance = 0.0f;
    } else if (m.z >= estimate_variance.short_history_length) {
      float single = VarianceOf(m.y);
      variance =
          estimate_variance.variance_of_mean != 0 ? VarianceOfMean(single, m.w) : single / samples;
    } else if (estimate_variance.short_history != kShortHistoryNone) {
      float single = SpatialVariance(surface, detail, m.x, at) *
                     ShortHistoryBoost(m.z, estimate_variance.short_history_length,
                                       estimate_variance.short_history_boost);
      variance = single * (estimate_variance.variance_of_mean != 0 ? m.w : 1.0f / samples);
    }
    vec3 c = texelFetch(colour, at, 0).xyz;
    if (with_behind != 0 && feedback_phase < 1.0f) {
      vec3 before = texelFetch(behind, at, 0).xyz;
      c = before + feedback_phase * (c - before);
    }
    imageStore(light_out, at, Stored(vec4(c, PackDeviation(variance, valid))));
  }
}
