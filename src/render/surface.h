// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The surface at a hit: position, orientation, material.
#pragma once

#include <map>
#include <memory>
#include <vector>

#include "render/energy_tables.h"
#include "render/make_bsdf_shared.h"
#include "render/path_shared.h"
#include "render/scene_state.h"

namespace stillray::render {

struct Surface : ShadingPoint {
  const Material* material = nullptr;
  vec3 base_colour;
  float metallic = 0;
  float roughness = 0;  ///< perceptual
  float transmission = 0;
  bool layered = false;  ///< PlacedInstance::layered
  SurfaceLayers layers = NoLayers();
};

/// The layers of a material, without textures.
SurfaceLayers LayersOf(const Material& material);

/// \param direction  unit direction of the incident ray
Surface MakeSurface(const SceneState& state, const Hit& hit, vec3 base_colour, vec3 direction);

/// Transmittance of a smooth thin sheet of this material for an undeflected ray at `cosine` with
/// its geometric normal; 0 for all other materials.
vec3 SheetTransmittance(const SceneState& state, const Hit& hit, float cosine);

/// Constructs BSDFs; holds the energy tables of the scene's materials.
class BsdfTables {
 public:
  /// \param regularise  whether min_alpha may be above 0
  BsdfTables(const Scene& scene, bool regularise);

  /// The surface's BSDF for its wo.
  /// \param min_alpha        minimum GGX alpha of path-space regularisation (ignored for smooth
  ///     thin sheets, which shadow rays pass undeflected)
  /// \param specular_albedo  [out] if not null; exact
  Bsdf Make(const Surface& surface, float min_alpha,
            SpecularAlbedo* specular_albedo = nullptr) const;

  size_t memory_bytes() const;

 private:
  GlassShare ShareOfGlass(const Surface& surface, float alpha) const;

  // Tables by refractive index, for materials that may be rough glass.
  std::map<float, std::unique_ptr<GlassEnergy>> glass_;
};

}  // namespace stillray::render
