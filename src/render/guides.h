// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The guides of a frame, and the radiance emitted by the visible surfaces and the background: all
/// free of noise.
#pragma once

#include "render/primary.h"
#include "stillray/frame.h"

namespace stillray::render {

/// Guides of one pixel. Emission, background and albedos are weighted sums over the pixel's layers;
/// the other members are taken from the layer with the largest weight. In pixels that separate
/// transmitted light (several layers, or a single opaque layer of smooth glass), albedos and the
/// other members are taken from the first layer.
struct PixelGuides {
  float depth = 0;
  vec3 normal;
  vec3 albedo;
  vec3 specular_albedo;
  /// If transmitted light is separate: transmission albedo of the glass, or the weight of all
  /// layers behind the first one. Otherwise 0: `specular_albedo` includes transmission.
  vec3 transmission_albedo = vec3(0.0f);
  vec2 motion;
  /// Only where the shape has changed, see StorePreviousNormals.
  vec3 previous_normal = vec3(0.0f);
  uint32_t id = 0;
  float roughness = 0;
  vec3 emission;
  vec3 background;

  bool separates_transmission() const { return transmission_albedo != vec3(0.0f); }
};

/// \param first  [out] first surface for TraceSample; unchanged unless the pixel has exactly one
///     layer
PixelGuides MakeGuides(const TraceContext& context, const PrimaryPixel& pixel, FirstSurface* first);

/// Motion of the surface at a pixel's hit, from this frame to the previous one.
vec2 MotionOfSurface(const TraceContext& context, const PrimaryPixel& pixel, const Hit& hit,
                     vec3 position);

/// The layer with the largest weight among layers `begin` and later; null if there is none.
const PrimaryLayer* HeaviestLayer(const PrimaryPixel& pixel, int begin);

/// The hit point in object space, before the transform of its instance.
/// \param positions  vertex positions of the mesh
vec3 LocalPoint(const Mesh& mesh, const vec3* positions, const Hit& hit);

/// Motion vector of points outside the view of the previous frame's camera.
vec2 MotionOutOfPicture(const CameraView& camera);

/// The radiance members of PixelGuides.
struct UnscatteredLight {
  vec3 emission;
  vec3 background;
};
UnscatteredLight FindUnscatteredLight(const TraceContext& context, const PrimaryPixel& pixel);

}  // namespace stillray::render
