// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "core/shared.h"
#include "denoise/stages/edge_stopping_shared.h"
#include "denoise/stages/estimate_variance.h"
#include "denoise/stages/estimate_variance_shared.h"

namespace stillray::reference {
namespace {

/// The neighbourhood of a pixel, with weights by the similarity of the surfaces.
struct Window {
  static constexpr int kSide = 2 * SignalHistory::kBorder + 1;
  int radius;
  float weight[kSide][kSide] = {};  ///< 0 without samples
  float mean[kSide][kSide] = {};
  float variance[kSide][kSide] = {};
};

Window WindowAt(const SignalHistory& h, const GuidePlanes& g, const EstimateVarianceParameters& p,
                int x, int y) {
  const EdgeStopping& e = p.edges;
  const vec2 slope = {g.gradient[0](x, y), g.gradient[1](x, y)};
  const vec2 pixel = {static_cast<float>(x), static_cast<float>(y)};
  Window window = {.radius = p.short_history_radius};
  for (int dy = -window.radius; dy <= window.radius; ++dy) {
    for (int dx = -window.radius; dx <= window.radius; ++dx) {
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
      const int row = dy + window.radius;
      const int column = dx + window.radius;
      window.weight[row][column] =
          NormalWeightAt(e, cosine, Turn2At(g, x, y), kLeastCurvedSigmaN) * exp(-depth);
      window.mean[row][column] = h.mean(qx, qy);
      window.variance[row][column] = h.variance(qx, qy);
    }
  }
  return window;
}

/// Variance of the pixels about their mean, from the spread.
float SpreadOf(const Window& window, float sum_weight) {
  const float centre = window.mean[window.radius][window.radius];
  float sum_d = 0;
  float sum_d2 = 0;
  for (int row = 0; row <= 2 * window.radius; ++row) {
    for (int column = 0; column <= 2 * window.radius; ++column) {
      const float d = window.mean[row][column] - centre;
      sum_d += window.weight[row][column] * d;
      sum_d2 += window.weight[row][column] * d * d;
    }
  }
  const float mean_d = sum_d / sum_weight;
  return max(sum_d2 / sum_weight - mean_d * mean_d, 0.0f);
}

/// Variance of the pixels, from the second differences along rows and columns.
float SecondDifferencesOf(const Window& window, float spread) {
  float square = 0;
  float weight = 0;
  for (int i = 0; i <= 2 * window.radius; ++i) {
    for (int j = 1; j < 2 * window.radius; ++j) {
      const auto add = [&](const float(&w)[3], const float(&l)[3]) {
        const float d = l[0] - 2 * l[1] + l[2];
        square += w[0] * w[1] * w[2] * d * d;
        weight += w[0] * w[1] * w[2];
      };
      add({window.weight[i][j - 1], window.weight[i][j], window.weight[i][j + 1]},
          {window.mean[i][j - 1], window.mean[i][j], window.mean[i][j + 1]});
      add({window.weight[j - 1][i], window.weight[j][i], window.weight[j + 1][i]},
          {window.mean[j - 1][i], window.mean[j][i], window.mean[j + 1][i]});
    }
  }
  return SecondDifferenceVariance(square, weight, spread);
}

/// Variance of single samples from the neighbourhood on the same surface.
float SpatialVariance(const SignalHistory& h, const GuidePlanes& g,
                      const EstimateVarianceParameters& p, int x, int y) {
  const Window window = WindowAt(h, g, p, x, y);
  float sum_weight = 0;
  float sum_variance = 0;
  for (int row = 0; row <= 2 * window.radius; ++row) {
    for (int column = 0; column <= 2 * window.radius; ++column) {
      sum_weight += window.weight[row][column];
      sum_variance += window.weight[row][column] * window.variance[row][column];
    }
  }
  if (sum_weight < p.least_evidence) {
    return kUnknownVariance;
  }
  if (!(sum_weight > 0)) {
    return 0;
  }
  const float spread = SpreadOf(window, sum_weight);
  const float between = p.short_history == kShortHistorySecondDifference
                            ? SecondDifferencesOf(window, spread)
                            : spread;
  return between + sum_variance / sum_weight;
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
  if (p.short_history == kShortHistoryNone) {
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
