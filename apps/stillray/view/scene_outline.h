// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Element counts of a glTF file, read quickly before the full import.
#pragma once

#include <cstddef>
#include <string>

namespace stillray::view {

struct SceneOutline {
  size_t textures = 0;
  size_t meshes = 0;
};

/// Reads only the JSON, at most 64 MiB of it. Errors are ignored, since the importer reports them;
/// unknown counts are 0.
SceneOutline OutlineOf(const std::string& path);

/// "14 textures and 251 meshes"; empty if all counts are unknown.
std::string ToText(const SceneOutline& outline);

}  // namespace stillray::view
