// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "core/colour_shared.h"
#include "denoise/stages/remodulate.h"

namespace stillray::reference {
namespace {

/// Radiance of a signal.
vec3 Radiance(const SignalLight& signal, const RemodulateParameters& p, int x, int y) {
  const float l = (*signal.light)[0](x, y);
  const float r = (*signal.light)[1](x, y);
  const float b = (*signal.light)[2](x, y);
  vec3 rgb = {r, p.luminance_rec601 ? Green601(l, r, b) : Green709(l, r, b), b};
  if (signal.albedo.channel >= 0) {
    rgb = vec3(0.0f);
    rgb[signal.albedo.channel] = l;
  }
  for (int c = 0; c < 3 && signal.albedo.count > 0; ++c) {
    float factor = 0;
    for (int i = 0; i < signal.albedo.count; ++i) {
      factor += (*signal.albedo.part[i])[c](x, y);
    }
    rgb[c] = stillray::Remodulate(rgb[c], std::isfinite(factor) ? factor : 1.0f);
  }
  return rgb;
}

}  // namespace

int64_t Remodulate(std::span<const SignalLight> signals, std::span<const Image3* const> unfiltered,
                   const RemodulateParameters& p, Image3* picture) {
  int64_t bad = 0;
  for (int y = 0; y < picture->height(); ++y) {
    for (int x = 0; x < picture->width(); ++x) {
      vec3 sum(0.0f);
      if (p.add) {
        sum = {(*picture)[0](x, y), (*picture)[1](x, y), (*picture)[2](x, y)};
      }
      for (const SignalLight& signal : signals) {
        sum += Radiance(signal, p, x, y);
      }
      for (const Image3* image : unfiltered) {
        const vec3 light = {(*image)[0](x, y), (*image)[1](x, y), (*image)[2](x, y)};
        const bool finite =
            std::isfinite(light.x) && std::isfinite(light.y) && std::isfinite(light.z);
        sum += finite ? light : vec3(0.0f);
        bad += finite ? 0 : 1;
      }
      for (int c = 0; c < 3; ++c) {
        (*picture)[c](x, y) = clamp(sum[c], -kMostPicture, kMostPicture);
      }
    }
  }
  return bad;
}

}  // namespace stillray::reference
