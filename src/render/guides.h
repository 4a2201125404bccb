// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The guides of a frame, and the light emitted by the visible surfaces or from behind them: all
/// without noise.
#pragma once

#include "render/primary.h"
#include "stillray/frame.h"

namespace stillray::render {

/// Guides of one pixel. Emission and background are weighted sums over the pixel's layers. So are
/// reflectances, while the other members are those of the layer with the largest weight; but if
/// transmitted light is separate, both belong to the first layer. It is in pixels with several
/// layers, and where the only one is opaque smooth glass.
struct PixelGuides {
  float depth = 0;
  vec3 normal;
  vec3 albedo;
  vec3 specular_albedo;
  /// If transmitted light is separate: that of the glass, or the weights of all layers behind the
  /// first one. Else 0: `specular_albedo` includes transmission.
  vec3 transmission_albedo = vec3(0.0f);
  vec2 motion;
  vec3 previous_normal = vec3(0.0f);  ///< where the shape has changed, see StorePreviousNormals
  uint32_t id = 0;
  float roughness = 0;
  vec3 emission;
  vec3 background;

  bool separates_transmission() const { return transmission_albedo != vec3(0.0f); }
};

/// \param first  [out] for TraceSample; unchanged unless the pixel has exactly one layer
PixelGuides MakeGuides(const TraceContext& context, const PrimaryPixel& pixel, FirstSurface* first);

/// Motion of the surface at a pixel's hit, from this frame to the previous one.
vec2 MotionOfSurface(const TraceContext& context, const PrimaryPixel& pixel, const Hit& hit,
                     vec3 position);

/// The layer with the largest weight from `begin` on; null: none.
const PrimaryLayer* HeaviestLayer(const PrimaryPixel& pixel, int begin);

/// The point of a hit before the transform of its instance.
/// \param positions  of the mesh's vertices
vec3 LocalPoint(const Mesh& mesh, const vec3* positions, const Hit& hit);

/// Motion of points that the previous frame's camera did not see.
vec2 MotionOutOfPicture(const CameraView& camera);

/// Only the light of PixelGuides.
struct UnscatteredLight {
  vec3 emission;
  vec3 background;
};
UnscatteredLight FindUnscatteredLight(const TraceContext& context, const PrimaryPixel& pixel);

}  // namespace stillray::render
