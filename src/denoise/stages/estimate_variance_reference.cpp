// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "core/shared.h"
#include "denoise/stages/edge_stopping_shared.h"
#include "denoise/stages/estimate_variance.h"
#include "denoise/stages/estimate_variance_shared.h"

namespace stillray::reference {
namespace {

/// Variance of single samples from the neighbourhood on the same surface, about this pixel's
/// mean.
float SpatialVariance(const SignalHistory& h, const GuidePlanes& g,
                      const EstimateVarianceParameters& p, int x, int y) {
  const EdgeStopping& e = p.edges;
  float sum_weight = 0;
  float sum_d = 0;
  float sum_d2 = 0;
  const vec2 slope = {g.gradient[0](x, y), g.gradient[1](x, y)};
  const vec2 pixel = {static_cast<float>(x), static_cast<float>(y)};
  const int radius = p.short_history_radius;
  for (int dy = -radius; dy <= radius; ++dy) {
    for (int dx = -radius; dx <= radius; ++dx) {
      const int qx = x + dx;
      const int qy = y + dy;
      if (qx < 0 || qy < 0 || qx >= h.mean.width() || qy >= h.mean.height() ||
          !(h.length(qx, qy) > 0) || !(g.inverse_depth(qx, qy) > 0)) {
        continue;
      }
      const float cosine = dot(NormalAt(g, x, y), NormalAt(g, qx, qy));
      const vec2 offset = {static_cast<float>(dx), static_cast<float>(dy)};
      const float ip = g.inverse_depth(x, y);
      const float iq = g.inverse_depth(qx, qy);
      const float depth = DepthExponent(e, ip, iq, slope, pixel, offset);
      const float w = NormalWeightAt(e, cosine, Turn2At(g, x, y)) * exp(-depth);
      const float d = h.mean(qx, qy) - h.mean(x, y);
      sum_weight += w;
      sum_d += w * d;
      sum_d2 += w * (h.variance(qx, qy) + d * d);
    }
  }
  if (sum_weight < p.least_evidence) {
    return kUnknownVariance;
  }
  if (!(sum_weight > 0)) {
    return 0;
  }
  const float mean_d = sum_d / sum_weight;
  return max(sum_d2 / sum_weight - mean_d * mean_d, 0.0f);
}

float Estimate(const VarianceSignal& signal, const GuidePlanes& guides,
               const EstimateVarianceParameters& p, int x, int y) {
  const SignalHistory& history = *signal.history;
  const float length = history.length(x, y);
  if (!(guides.inverse_depth(x, y) > 0) || !(length > 0)) {
    return 0;
  }
  const float n = signal.samples != nullptr ? max((*signal.samples)(x, y), 1.0f) : 1.0f;
  const float weights2 = history.weights2(x, y);
  if (length >= p.short_history_length) {
    const float temporal = history.variance(x, y);
    return p.variance_of_mean != 0 ? VarianceOfMean(temporal, weights2) : temporal / n;
  }
  if (p.short_history_spatial == 0) {
    return 0;
  }
  const float spatial = SpatialVariance(history, guides, p, x, y) *
                        ShortHistoryBoost(length, p.short_history_length, p.short_history_boost);
  return spatial * (p.variance_of_mean != 0 ? weights2 : 1.0f / n);
}

}  // namespace

void EstimateVariance(std::span<VarianceSignal> signals, const GuidePlanes& guides,
                      const EstimateVarianceParameters& p) {
  for (VarianceSignal& signal : signals) {
    bool all_valid = true;
    for (int y = 0; y < signal.variance->height(); ++y) {
      for (int x = 0; x < signal.variance->width(); ++x) {
        (*signal.variance)(x, y) = Estimate(signal, guides, p, x, y);
        if (guides.inverse_depth(x, y) > 0 && !(signal.history->length(x, y) > 0)) {
          all_valid = false;
        }
      }
    }
    signal.all_valid = all_valid;
  }
}

}  // namespace stillray::reference
