// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The sources of a layer's guides, and the signals and albedos of each source.
#pragma once

#include <cstdint>

#include "denoise/stages/select_guides_shared.h"
#include "stillray/denoise.hpp"
#include "stillray/frame.h"

namespace stillray {

/// The source of a layer's guides.
enum class GuideSource : uint8_t { kSurface, kReflection, kRefraction };

/// Whether signals of this kind belong to the layer of reflected or refracted light with this
/// source.
inline bool IsLightOf(GuideSource source, SignalKind kind) {
  using enum SignalKind;
  return source == GuideSource::kReflection
             ? kind == kDirectSpecular || kind == kIndirectSpecular
             : kind == kDirectTransmission || kind == kIndirectTransmission;
}

/// The virtual guides of a layer. \p source is not kSurface.
inline const VirtualGuides& ImageOf(const Frame& frame, GuideSource source) {
  return source == GuideSource::kReflection ? frame.reflection : frame.refraction;
}

/// The albedo of the surface by which the layer's radiance is divided.
inline const Image3& SurfaceAlbedoOf(const Guides& guides, GuideSource source) {
  return source == GuideSource::kReflection ? guides.specular_albedo : guides.transmission_albedo;
}
inline Image3& SurfaceAlbedoOf(Guides& guides, GuideSource source) {
  return source == GuideSource::kReflection ? guides.specular_albedo : guides.transmission_albedo;
}

/// The divisor of the other layer: specular albedo for refraction, transmission albedo for
/// reflection.
inline const Image3& OtherAlbedoOf(const Guides& guides, GuideSource source) {
  return source == GuideSource::kReflection ? guides.transmission_albedo : guides.specular_albedo;
}

/// Parameters of select_guides. Renderers give virtual guides of transmitted light only where a
/// transmitted surface is visible, for any roughness of the surface, which is meaningless for alpha
/// blending.
/// \param of_reflection  the parameters of reflected light
inline SelectGuidesParameters SelectGuidesOf(const SelectGuidesParameters& of_reflection,
                                             GuideSource source) {
  return source == GuideSource::kReflection
             ? of_reflection
             : SelectGuidesParameters{
                   .virtual_roughness = 1.0f, .image_normal = -1.0f, .virtual_motion_roughness = 0};
}

inline SelectGuidesParameters SelectGuidesOf(const Settings& s, GuideSource source) {
  return SelectGuidesOf(
      SelectGuidesParameters{.virtual_roughness = s.virtual_roughness,
                             .image_normal = 1.0f,
                             .virtual_motion_roughness = s.virtual_motion_roughness},
      source);
}

}  // namespace stillray
