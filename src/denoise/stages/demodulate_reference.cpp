// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "core/colour.h"
#include "core/colour_shared.h"
#include "denoise/stages/demodulate.h"
#include "denoise/stages/demodulate_shared.h"

namespace stillray::reference {
namespace {

vec3 Load(const Image3& image, int x, int y) {
  return {image[0](x, y), image[1](x, y), image[2](x, y)};
}

bool IsFinite(vec3 v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

vec3 AlbedoOf(const DemodulateInput& in, int x, int y) {
  vec3 albedo(0.0f);
  for (int i = 0; i < in.albedo.count; ++i) {
    albedo += Load(*in.albedo.part[i], x, y);
  }
  return albedo;
}

/// Variance of single samples of the signal: the sum over its terms of the variance about the
/// term's mean, converted from the term's albedo to the signal's. The terms are assumed to be
/// uncorrelated.
float WithinVariance(const DemodulateInput& in, int x, int y, vec3 albedo) {
  float sum = 0;
  for (int i = 0; i < in.count; ++i) {
    if (in.second_moment[i] == nullptr) {
      continue;
    }
    const vec3 own = in.own_albedo[i] != nullptr ? Load(*in.own_albedo[i], x, y) : vec3(1.0f);
    const vec3 light = stillray::Demodulate(Load(*in.radiance[i], x, y), own);
    const float mean = Luminance709(light);
    const int c = in.albedo.channel;
    const float ratio = c >= 0 ? ChannelDeviation(light[c], mean, own[c], albedo[c])
                               : std::max(Luminance709(own), kAlbedoFloor) /
                                     std::max(Luminance709(albedo), kAlbedoFloor);
    const float variance = std::max((*in.second_moment[i])(x, y) - mean * mean, 0.0f);
    sum += variance * ratio * ratio;
  }
  return std::isfinite(sum) ? sum : 0.0f;
}

}  // namespace

DemodulateCounts Demodulate(const DemodulateInput& in, NewLight* out) {
  const bool divide = in.albedo.count > 0;
  DemodulateCounts counts;
  for (int y = 0; y < out->colour.height(); ++y) {
    for (int x = 0; x < out->colour.width(); ++x) {
      vec3 sum(0.0f);
      bool finite = true;
      bool negative = false;
      for (int i = 0; i < in.count; ++i) {
        const vec3 light = Load(*in.radiance[i], x, y);
        finite = finite && IsFinite(light);
        const float least = std::min({light.x, light.y, light.z});
        negative = negative || least < -in.negative_limit;
        sum += max(light, vec3(0.0f));
      }
      const vec3 albedo = divide ? AlbedoOf(in, x, y) : vec3(1.0f);
      vec3 colour = divide ? stillray::Demodulate(sum, albedo) : sum;
      finite = finite && IsFinite(colour) && IsFinite(albedo);
      const float given = in.samples != nullptr ? (*in.samples)(x, y) : 1.0f;
      const bool usable = finite && !negative && given > 0 && std::isfinite(given);
      counts.non_finite += given > 0 && !finite ? 1 : 0;
      counts.negative += given > 0 && finite && negative ? 1 : 0;
      float luminance = in.luminance_rec601 ? Luminance601(colour.x, colour.y, colour.z)
                                            : Luminance709(colour.x, colour.y, colour.z);
      if (in.albedo.channel >= 0) {
        luminance = colour[in.albedo.channel];
        colour = vec3(luminance);
      }
      out->colour[0](x, y) = usable ? luminance : 0.0f;
      out->colour[1](x, y) = usable ? colour.x : 0.0f;
      out->colour[2](x, y) = usable ? colour.z : 0.0f;
      out->samples(x, y) = usable ? given : 0.0f;
      if (!out->within.empty()) {
        out->within(x, y) = usable ? WithinVariance(in, x, y, albedo) : 0.0f;
      }
    }
  }
  return counts;
}

}  // namespace stillray::reference
