// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "core/check.h"
#include "core/colour_shared.h"
#include "denoise/stages/atrous.h"
#include "denoise/stages/edge_stopping_shared.h"

namespace stillray::reference {
namespace {

constexpr float kKernel3[2] = {0.5f, 0.25f};
constexpr float kKernel5[3] = {3.0f / 8.0f, 1.0f / 4.0f, 1.0f / 16.0f};

float Luminance(const FilterPlanes& f, int x, int y, bool rec601) {
  return (rec601 ? Luminance601 : Luminance709)(f.colour[0](x, y), f.colour[1](x, y),
                                                f.colour[2](x, y));
}

/// The product of all edge-stopping weights of q = (qx, qy) as seen from p = (x, y).
float EdgeWeight(const FilterPlanes& in, const Image1& spread, const GuidePlanes& g,
                 const AtrousParameters& p, bool centre_present, int x, int y, int qx, int qy) {
  if (p.weights == AtrousWeights::kNaive) {
    return 1;
  }
  if (p.test_id && g.id(x, y) != g.id(qx, qy)) {
    return 0;
  }
  const vec3 np = {g.normal[0](x, y), g.normal[1](x, y), g.normal[2](x, y)};
  const vec3 nq = {g.normal[0](qx, qy), g.normal[1](qx, qy), g.normal[2](qx, qy)};
  const float ip = g.inverse_depth(x, y);
  const float iq = g.inverse_depth(qx, qy);
  const vec2 slope = {g.gradient[0](x, y), g.gradient[1](x, y)};
  const vec2 offset = {static_cast<float>(qx - x), static_cast<float>(qy - y)};
  const float lp = Luminance(in, x, y, p.rec601);
  const float lq = Luminance(in, qx, qy, p.rec601);
  if (p.weights == AtrousWeights::kEaw) {
    const float plane = PlaneDepthExponent(ip, iq, slope, offset, 1.0f);
    const float dl = centre_present ? lp - lq : 0.0f;
    return exp(-EawExponent(dl * dl, dot(np - nq, np - nq), plane * plane, p.eaw_sigma_l,
                            p.eaw_sigma_n, p.eaw_sigma_z));
  }
  const EdgeStopping& e = p.edges;
  float exponent = e.plane ? PlaneDepthExponent(ip, iq, slope, offset, e.plane_tolerance)
                           : GradientDepthExponent(ip, iq, slope, offset, e.sigma_z,
                                                   e.depth_epsilon, e.max_slope);
  if (p.weights == AtrousWeights::kSvgf) {
    const float noise = SharedSpread(spread(x, y), spread(qx, qy), p.noise_ratio);
    exponent += LuminanceExponent(lp, lq, noise, p.sigma_l, p.luminance_epsilon);
  }
  return NormalWeight(dot(np, nq), e.sigma_n) * exp(-exponent);
}

void FilterPixel(const FilterPlanes& in, const Image1& spread, const Image1& present,
                 const GuidePlanes& g, const AtrousParameters& p, int x, int y, FilterPlanes* out) {
  const float* kernel = p.radius == 1 ? kKernel3 : kKernel5;
  const bool centre_present = present(x, y) > 0;
  float sum_weight = 0;
  float sum_variance = 0;
  vec3 sum(0.0f);
  for (int dy = -p.radius; dy <= p.radius; ++dy) {
    for (int dx = -p.radius; dx <= p.radius; ++dx) {
      const int qx = x + dx * p.step;
      const int qy = y + dy * p.step;
      if (!(present(qx, qy) > 0)) {
        continue;
      }
      const bool centre = dx == 0 && dy == 0;
      const float edge = centre ? 1.0f : EdgeWeight(in, spread, g, p, centre_present, x, y, qx, qy);
      const float w = kernel[abs(dx)] * kernel[abs(dy)] * edge;
      sum += w * vec3(in.colour[0](qx, qy), in.colour[1](qx, qy), in.colour[2](qx, qy));
      sum_variance += w * w * in.variance(qx, qy);
      sum_weight += w;
    }
  }
  // Below this the sums have lost their digits: nothing near is like this pixel.
  const bool filled = sum_weight > kMinAtrousWeight;
  for (int c = 0; c < 3; ++c) {
    out->colour[c](x, y) = filled ? sum[c] / sum_weight : in.colour[c](x, y);
  }
  out->variance(x, y) = filled ? sum_variance / (sum_weight * sum_weight) : in.variance(x, y);
  if (p.grown != nullptr) {
    (*p.grown)(x, y) = filled || centre_present ? 1.0f : 0.0f;
  }
}

}  // namespace

void Atrous(const FilterPlanes& in, const Image1& spread, const Image1& present,
            const GuidePlanes& guides, const AtrousParameters& p, FilterPlanes* out) {
  STILLRAY_CHECK_LE(p.step * p.radius, present.border());
  STILLRAY_CHECK_LE(p.step * p.radius, guides.inverse_depth.border());
  for (int y = 0; y < present.height(); ++y) {
    for (int x = 0; x < present.width(); ++x) {
      const bool surface = guides.inverse_depth(x, y) > 0;
      if (surface) {
        FilterPixel(in, spread, present, guides, p, x, y, out);
        continue;
      }
      for (int c = 0; c < 3; ++c) {
        out->colour[c](x, y) = in.colour[c](x, y);
      }
      out->variance(x, y) = in.variance(x, y);
      if (p.grown != nullptr) {
        (*p.grown)(x, y) = present(x, y);
      }
    }
  }
}

}  // namespace stillray::reference
