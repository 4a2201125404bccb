// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The guides of a frame, and the light emitted by the visible surfaces or from behind them: all
/// without noise.
#pragma once

#include "render/primary.h"
#include "stillray/frame.h"

namespace stillray::render {

/// Guides of one pixel. Reflectances and light are weighted sums over the pixel's layers; the other
/// members are those of the layer with the largest weight.
struct PixelGuides {
  float depth = 0;
  vec3 normal;
  vec3 albedo;
  vec3 specular_albedo;
  vec2 motion;
  vec3 previous_normal = vec3(0.0f);  ///< where the shape has changed, see StorePreviousNormals
  uint32_t id = 0;
  float roughness = 0;
  vec3 emission;
  vec3 background;
};

/// \param first  [out] for TraceSample; unchanged unless the pixel has exactly one layer
PixelGuides MakeGuides(const TraceContext& context, const PrimaryPixel& pixel, FirstSurface* first);

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
