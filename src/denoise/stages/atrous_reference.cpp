// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "core/check.h"
#include "core/parallel.h"
#include "denoise/stages/atrous.h"
#include "denoise/stages/edge_stopping_shared.h"

namespace stillray::reference {
namespace {

constexpr float kKernel3[2] = {0.5f, 0.25f};
constexpr float kKernel5[3] = {3.0f / 8.0f, 1.0f / 4.0f, 1.0f / 16.0f};

/// Number of colour planes that are filtered.
int ChannelsOf(int weights) {
  return weights == kAtrousGeometry ? 2 : 3;
}

/// The product of all edge-stopping weights between p = (x, y) and q = (qx, qy).
float EdgeWeight(const AtrousSignal& signal, const GuidePlanes& g, const AtrousLevel& level,
                 const AtrousParameters& p, int x, int y, int qx, int qy) {
  if (level.weights == kAtrousNaive) {
    return 1;
  }
  if (level.weights != kAtrousGeometry && p.wavelet_id != 0 && g.id(x, y) != g.id(qx, qy)) {
    return 0;
  }
  const vec3 np = NormalAt(g, x, y);
  const vec3 nq = NormalAt(g, qx, qy);
  const float ip = g.inverse_depth(x, y);
  const float iq = g.inverse_depth(qx, qy);
  const vec2 slope = {g.gradient[0](x, y), g.gradient[1](x, y)};
  const vec2 offset = {static_cast<float>(qx - x), static_cast<float>(qy - y)};
  const bool has_pilot = signal.pilot != nullptr && level.weights == kAtrousSvgf;
  const Image1& luminance = has_pilot ? *signal.pilot : (*signal.colour)[0];
  const float dl = abs(luminance(x, y) - luminance(qx, qy));
  const EdgeStopping& e = p.edges;
  const vec2 pixel = {static_cast<float>(x), static_cast<float>(y)};
  if (level.weights == kAtrousEaw) {
    const bool by_position = e.depth_weight_position != 0;
    const float plane = by_position ? 0.0f : PlaneDepthExponent(ip, iq, slope, offset, 1.0f);
    const float position = by_position ? DepthExponent(e, ip, iq, slope, pixel, offset) : 0.0f;
    const float known_dl = (*signal.valid)(x, y) > 0 ? dl : 0.0f;
    return exp(-position - EawExponent(known_dl * known_dl, dot(np - nq, np - nq), plane * plane,
                                       signal.eaw_sigma_l, p.eaw_sigma_n, p.eaw_sigma_z));
  }
  const float depth = DepthExponent(e, ip, iq, slope, pixel, offset);
  const bool reflected = signal.reflected && level.weights == kAtrousSvgf;
  const float least = reflected ? kLeastReflectedSigmaN : kLeastCurvedSigmaN;
  const float geometry = NormalWeightAt(e, dot(np, nq), Turn2At(g, x, y), least) * exp(-depth);
  if (level.weights == kAtrousGeometry) {
    return geometry;
  }
  const Image1& factor = *signal.luminance_factor;
  if (has_pilot && !((*signal.valid)(x, y) > 0)) {
    return geometry;  // no luminance weight
  }
  return geometry *
         std::exp2(-dl * SharedLuminanceFactor(factor(x, y), factor(qx, qy), p.noise_ratio));
}

/// The weight of the tap (dx, dy) of pixel (x, y); 0 if the tap has no samples.
float TapWeight(const AtrousSignal& signal, const GuidePlanes& g, const AtrousLevel& level,
                const AtrousParameters& p, int x, int y, int dx, int dy) {
  const float* kernel = level.radius == 1 ? kKernel3 : kKernel5;
  const int qx = x + dx * level.step;
  const int qy = y + dy * level.step;
  if (!((*signal.valid)(qx, qy) > 0)) {
    return 0;
  }
  const bool centre = dx == 0 && dy == 0;
  const float edge = centre ? 1.0f : EdgeWeight(signal, g, level, p, x, y, qx, qy);
  return (level.box ? 1.0f : kernel[abs(dx)] * kernel[abs(dy)]) * edge;
}

void FilterPixel(const AtrousSignal& signal, const GuidePlanes& g, const AtrousLevel& level,
                 const AtrousParameters& p, int x, int y) {
  const LumaImage3& in = *signal.colour;
  float sum_weight = 0;
  float sum_variance = 0;
  vec3 sum(0.0f);
  for (int dy = -level.radius; dy <= level.radius; ++dy) {
    for (int dx = -level.radius; dx <= level.radius; ++dx) {
      const int qx = x + dx * level.step;
      const int qy = y + dy * level.step;
      if (!((*signal.valid)(qx, qy) > 0)) {
        continue;
      }
      const float w = TapWeight(signal, g, level, p, x, y, dx, dy);
      sum += w * vec3(in[0](qx, qy), in[1](qx, qy), in[2](qx, qy));
      sum_variance += w * w * (*signal.variance)(qx, qy);
      sum_weight += w;
    }
  }
  // Smaller sums are imprecise: no neighbour is similar to this pixel.
  const bool filled = sum_weight > kMinAtrousWeight;
  for (int c = 0; c < ChannelsOf(level.weights); ++c) {
    signal.out->colour[c](x, y) = filled ? sum[c] / sum_weight : in[c](x, y);
  }
  signal.out->variance(x, y) =
      filled ? sum_variance / (sum_weight * sum_weight) : (*signal.variance)(x, y);
  if (signal.valid_out != nullptr) {
    (*signal.valid_out)(x, y) = filled || (*signal.valid)(x, y) > 0 ? 1.0f : 0.0f;
  }
}

void PassThrough(const AtrousSignal& signal, int x, int y) {
  for (int c = 0; c < 3; ++c) {
    signal.out->colour[c](x, y) = (*signal.colour)[c](x, y);
  }
  signal.out->variance(x, y) = (*signal.variance)(x, y);
  if (signal.valid_out != nullptr) {
    (*signal.valid_out)(x, y) = (*signal.valid)(x, y);
  }
}

}  // namespace

void Atrous(std::span<const AtrousSignal> signals, const GuidePlanes& guides,
            const AtrousLevel& level, const AtrousParameters& p) {
  for (const AtrousSignal& signal : signals) {
    STILLRAY_CHECK_LE(ReachOf(level), signal.valid->border());
    for (int y = 0; y < signal.valid->height(); ++y) {
      for (int x = 0; x < signal.valid->width(); ++x) {
        if (level.weights == kAtrousGeometry && !((*signal.valid)(x, y) > 0)) {
          continue;
        }
        if (guides.inverse_depth(x, y) > 0) {
          FilterPixel(signal, guides, level, p, x, y);
        } else {
          PassThrough(signal, x, y);
        }
      }
    }
  }
}

}  // namespace stillray::reference

namespace stillray {

void SumAtrousWeights(const AtrousSignal& signal, const GuidePlanes& guides,
                      const AtrousLevel& level, const AtrousParameters& p, Image1* sums) {
  ParallelRows(sums->height(), 8, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      for (int x = 0; x < sums->width(); ++x) {
        float sum = 0;
        for (int dy = -level.radius; dy <= level.radius; ++dy) {
          for (int dx = -level.radius; dx <= level.radius; ++dx) {
            sum += guides.inverse_depth(x, y) > 0
                       ? reference::TapWeight(signal, guides, level, p, x, y, dx, dy)
                       : 0.0f;
          }
        }
        (*sums)(x, y) = sum;
      }
    }
  });
}

}  // namespace stillray
