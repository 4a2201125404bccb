// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// What a frame tells of the surfaces that its pixels see, and the light that comes from those
/// surfaces themselves or from behind them: all without noise.
#pragma once

#include "render/primary.h"
#include "stillray/frame.h"

namespace stillray::render {

/// Of one pixel. Reflectances and light are sums over the pixel's layers by their weights; the rest
/// is that of the layer with the largest weight.
struct PixelGuides {
  float depth = 0;
  vec3 normal;
  vec3 albedo;
  vec3 specular_albedo;
  vec2 motion;
  uint32_t id = 0;
  float roughness = 0;
  vec3 emission;
  vec3 background;
};

/// \param first  [out] for TraceSample; left alone unless the pixel has just one layer
PixelGuides MakeGuides(const TraceContext& context, const PrimaryPixel& pixel, FirstSurface* first);

/// The light of PixelGuides alone.
struct UnscatteredLight {
  vec3 emission;
  vec3 background;
};
UnscatteredLight FindUnscatteredLight(const TraceContext& context, const PrimaryPixel& pixel);

}  // namespace stillray::render
