// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Where the guides of a layer come from, and what belongs to each source.
#pragma once

#include <cstdint>

#include "denoise/stages/select_guides_shared.h"
#include "stillray/denoise.hpp"
#include "stillray/frame.h"

namespace stillray {

/// Where the guides of a layer come from.
enum class GuideSource : uint8_t { kSurface, kReflection, kRefraction };

/// Whether light of this kind belongs to such a layer.
inline bool IsLightOf(GuideSource source, SignalKind kind) {
  using enum SignalKind;
  return source == GuideSource::kReflection
             ? kind == kDirectSpecular || kind == kIndirectSpecular
             : kind == kDirectTransmission || kind == kIndirectTransmission;
}

/// The virtual guides of a layer that has some.
inline const VirtualGuides& ImageOf(const Frame& frame, GuideSource source) {
  return source == GuideSource::kReflection ? frame.reflection : frame.refraction;
}

/// The albedo of the surface that divides the light of such a layer.
inline const Image3& SurfaceAlbedoOf(const Guides& guides, GuideSource source) {
  return source == GuideSource::kReflection ? guides.specular_albedo : guides.transmission_albedo;
}
inline Image3& SurfaceAlbedoOf(Guides& guides, GuideSource source) {
  return source == GuideSource::kReflection ? guides.specular_albedo : guides.transmission_albedo;
}

/// The albedo that divides the light of the other kind of image.
inline const Image3& OtherAlbedoOf(const Guides& guides, GuideSource source) {
  return source == GuideSource::kReflection ? guides.transmission_albedo : guides.specular_albedo;
}

/// Renderers give images of transmitted light only where it shows some, whatever the roughness of
/// the surface: that of an alpha-blended one says nothing about what is seen through it.
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
