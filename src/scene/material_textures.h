// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// A list of the textures of a material, for code that handles all of them uniformly.
#pragma once

#include "stillray/scene.h"

namespace stillray {

struct MaterialTexture {
  const char* name;  ///< for error messages
  TextureRef Material::*slot;
};

inline constexpr MaterialTexture kMaterialTextures[] = {
    {"base colour texture", &Material::base_color_texture},
    {"metallic-roughness texture", &Material::metallic_roughness_texture},
    {"normal texture", &Material::normal_texture},
    {"emissive texture", &Material::emissive_texture},
    {"transmission texture", &Material::transmission_texture},
    {"specular texture", &Material::specular_texture},
    {"specular colour texture", &Material::specular_color_texture},
    {"clear coat texture", &Material::clearcoat_texture},
    {"clear coat roughness texture", &Material::clearcoat_roughness_texture},
    {"clear coat normal texture", &Material::clearcoat_normal_texture},
    {"sheen colour texture", &Material::sheen_color_texture},
    {"sheen roughness texture", &Material::sheen_roughness_texture},
    {"diffuse transmission texture", &Material::diffuse_transmission_texture},
    {"diffuse transmission colour texture", &Material::diffuse_transmission_color_texture},
    {"anisotropy texture", &Material::anisotropy_texture},
    {"iridescence texture", &Material::iridescence_texture},
    {"iridescence thickness texture", &Material::iridescence_thickness_texture},
};

}  // namespace stillray
