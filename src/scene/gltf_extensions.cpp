// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <string>
#include <string_view>

#include <fmt/format.h>

#include "scene/gltf_import.h"

namespace stillray {

namespace {

constexpr std::array<std::string_view, 16> kKnownExtensions = {
    "EXT_texture_webp",
    "KHR_lights_punctual",
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_diffuse_transmission",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_iridescence",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_volume",
    "KHR_materials_volume_scatter",
    "KHR_mesh_quantization",
    "KHR_texture_transform",
};

bool IsKnown(const std::string& name) {
  return std::find(kKnownExtensions.begin(), kKnownExtensions.end(), name) !=
         kKnownExtensions.end();
}

}  // namespace

void CheckExtensions(GltfImport* import) {
  const JsonView root = import->Root();
  const size_t required = root.Size("extensionsRequired");
  for (size_t i = 0; i < required && import->log.ok(); ++i) {
    const std::string name = root.StringItem("extensionsRequired", i);
    if (import->log.ok() && !IsKnown(name)) {
      import->log.Fail(Status::Unsupported(fmt::format(
          "extensionsRequired[{}]: stillray does not know the extension {}", i, Printable(name))));
    }
  }
  const size_t used = root.Size("extensionsUsed");
  for (size_t i = 0; i < used && import->log.ok(); ++i) {
    const std::string name = root.StringItem("extensionsUsed", i);
    if (import->log.ok() && !IsKnown(name)) {
      import->log.Warn(fmt::format("{} is not supported and was left out", Printable(name)));
    }
  }
}

}  // namespace stillray
